"""How matches are played: in lockstep, in processes of this machine or on a Ray cluster."""
