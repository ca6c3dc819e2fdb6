"""A study while it is run: participants on their way, the rooms they play in, and the experimenter's screen."""
