"""`movingout match`."""
