"""`movingout study`, with serving."""
