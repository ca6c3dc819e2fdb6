"""`movingout study simulate`."""
