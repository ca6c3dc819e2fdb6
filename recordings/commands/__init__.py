"""`movingout recordings`."""
