"""A language model as partner: the model says what to do, and scripted skills do it at 10 Hz."""
