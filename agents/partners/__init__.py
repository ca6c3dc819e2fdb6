"""Partners of many makes: families that differ in how they are built, to train with and to measure with."""
