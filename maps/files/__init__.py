"""Files that people name: reading and writing them."""
