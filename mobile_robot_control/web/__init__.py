"""Scripts and data of pages in a browser, shared by reports and the live page."""
