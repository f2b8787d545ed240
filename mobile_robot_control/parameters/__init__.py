"""Parameters: declared once, checked as a whole, read from files and written to them."""
