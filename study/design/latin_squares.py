"""Balanced orders: Williams squares, and the crossing of several factors.

A Williams square for n treatments has every treatment once in each position, and every treatment directly before every
other equally often, so that carry-over affects all equally (Williams 1949). Even n takes n rows; odd n takes 2n, the
square and its mirror.
"""

from collections.abc import Sequence
from math import lcm


def williams(n: int) -> tuple[tuple[int, ...], ...]:
    """The rows of a Williams square of the treatments 0 to n - 1."""
    first = [0]
    for step in range(1, n):
        first.append((first[-1] + (step if step % 2 else -step)) % n)
    rows = [tuple((start + shift) % n for start in first) for shift in range(n)]
    if n % 2 and n > 1:
        rows += [tuple(reversed(row)) for row in rows]
    return tuple(rows)


def crossed(slot: int, levels: Sequence[int]) -> tuple[int, ...]:
    """One level of each factor for the slot, such that

    - in any first so many slots, the levels of a factor occur equally often, give or take one;
    - factors do not move in step: after as many slots as there are combinations, every combination came up equally
      often.

    Each factor counts upwards with the slot, and takes one extra step whenever all combinations of the factors before
    it and its own levels have come round to the beginning together. Put the factors first that must cross soonest.
    """
    chosen: list[int] = []
    combinations = 1  # of the factors so far
    for count in levels:
        round_trip = lcm(combinations, count)
        combinations *= count
        chosen.append((slot + slot % combinations // round_trip) % count)
    return tuple(chosen)
