"""Training data: episodes are played, labelled by an expert, and cut into windows."""
