"""The process in which agents decide, and its messages to the server."""
