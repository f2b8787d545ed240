"""Messages of the loop: from bytes to quantities and back."""
