"""What survives a restart: rooms, recordings, answers."""
