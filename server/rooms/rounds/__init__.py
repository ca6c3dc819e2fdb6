"""One round while it is played: its world, recording and quality, pings, and who brought what home."""
