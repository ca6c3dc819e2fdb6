"""A study while it is run: participants, the rooms they play in, and the experimenter's page."""
