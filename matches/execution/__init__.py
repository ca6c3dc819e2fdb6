"""How matches are played: on processes of this machine, or on Ray."""
