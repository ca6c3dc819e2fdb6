"""The server's side of the worker processes that run agents."""
