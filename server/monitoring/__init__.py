"""What a server tells those who run it: its log, its state, its measures, and whether it has room for more."""
