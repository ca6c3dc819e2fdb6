"""`movingout maps`."""
