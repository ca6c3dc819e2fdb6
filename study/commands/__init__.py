"""`movingout study`, without serving."""
