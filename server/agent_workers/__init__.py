"""Worker processes in which agents decide, as the server sees them."""
