"""Commands that start, check or measure a server."""
