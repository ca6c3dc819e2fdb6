"""`movingout study`, with the commands that need a server."""
