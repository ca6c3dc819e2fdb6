"""Reading files that people name."""
