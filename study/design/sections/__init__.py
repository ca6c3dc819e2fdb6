"""The parts that a study file is made of, each checked by itself."""
