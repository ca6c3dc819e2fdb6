"""The process in which agents decide, and what it says to the server."""
