"""One number from several trainings: means with standard errors that count nothing twice."""

import math
from collections.abc import Iterable, Mapping, Sequence

from movingout.world.estimates import Estimate, estimate


def pooled(parts: Sequence[Estimate]) -> Estimate:
    """What `estimate` would give for the values of all parts together."""
    n = sum(part.n for part in parts)
    mean = math.fsum(part.mean * part.n for part in parts) / n
    within = math.fsum((part.stderr or 0.0) ** 2 * part.n * (part.n - 1) for part in parts)
    apart = math.fsum(part.n * (part.mean - mean) ** 2 for part in parts)
    return Estimate(mean, math.sqrt((within + apart) / (n - 1) / n) if n > 1 else None, n)


def averaged(parts: Sequence[Estimate]) -> Estimate:
    """The mean of means that have errors of their own, as by the jackknife; without an error where one has none."""
    errors = [part.stderr for part in parts if part.stderr is not None]
    whole = len(errors) == len(parts)
    return Estimate(
        math.fsum(part.mean for part in parts) / len(parts),
        math.sqrt(math.fsum(error**2 for error in errors)) / len(parts) if whole else None,
        sum(part.n for part in parts),
    )


def of_the_same_samples(parts: Sequence[Estimate]) -> Estimate:
    """The mean of means that were measured on the same samples: they err together, so more of them err no less.

    The error is the mean of theirs, and n counts the samples of one, of the one that has most: a choice is measured in
    those of the same moments in which a training's own candidates differ.
    """
    errors = [part.stderr for part in parts if part.stderr is not None]
    return Estimate(
        math.fsum(part.mean for part in parts) / len(parts),
        math.fsum(errors) / len(errors) if len(errors) == len(parts) else None,
        max(part.n for part in parts),
    )


def between(parts: Iterable[Estimate | None]) -> Estimate | None:
    """The mean of the means of trainings, with the error between them; None for fewer than two."""
    means = [part.mean for part in parts if part is not None]
    return estimate(means) if len(means) > 1 else None


def fields(parts: Sequence[Mapping[str, Estimate]], name: str) -> list[Estimate]:
    """A field of those parts that have it."""
    return [part[name] for part in parts if name in part]
