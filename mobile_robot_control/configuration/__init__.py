"""The parameters of the four nodes together: declared, checked, read from files and written to them."""
