"""What a learned agent sees."""
