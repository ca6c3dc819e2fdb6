"""Rounds of a study: rooms opened for them, how they ended, and what is kept of those a killed server had."""
