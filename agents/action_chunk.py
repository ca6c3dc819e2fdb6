"""Action chunks: validation, and conversion to what `World.step` takes."""

import inspect
from collections.abc import Sequence
from numbers import Integral

import numpy as np

from movingout.agents.base import ActionChunk, Agent
from movingout.agents.errors import AgentError
from movingout.world.action import to_world
from movingout.world.state import Floats

MAX_ROWS = 64  # a chunk is at most 6.4 s long

NEUTRAL: tuple[float, float, float] = (0.0, 0.0, 0.0)
"""The world action of a seat whose agent did not answer: stand still, keep heading and grasp."""


def checked_chunk(answer: object) -> ActionChunk:
    """Return `answer` as a clean (H, 4) float64 array: distance clipped to [-1, 1], toggles 0 or 1.

    Raises AgentError when the shape is wrong, a number is not finite, or the heading (cos, sin) is the zero vector.
    """
    if inspect.iscoroutine(answer):
        answer.close()  # nobody will await it, which Python would warn of
        raise AgentError("act() is async; nobody awaits its answer, so write a plain def")
    if answer is None:
        raise AgentError("act() returned None; it returns an action chunk, a (H, 4) array of numbers")
    try:
        chunk = np.asarray(answer, dtype=np.float64).copy()  # np.array would warn of tensors
    except Exception as error:  # what a foreign array raises: a tensor of torch that requires grad, a RuntimeError
        what = type(answer).__name__
        raise AgentError(
            f"an action chunk is a (H, 4) array of numbers, which this {what} is not: {error}"[:200]
        ) from error
    if chunk.ndim != 2 or chunk.shape[1] != 4 or not 1 <= chunk.shape[0] <= MAX_ROWS:
        raise AgentError(f"an action chunk has shape (H, 4) with H from 1 to {MAX_ROWS}, not {chunk.shape}")
    if not np.isfinite(chunk).all():
        raise AgentError("an action chunk must hold finite numbers; this one has NaN or infinity")
    if (np.hypot(chunk[:, 1], chunk[:, 2]) < 1e-6).any():
        raise AgentError("columns 1 and 2 of an action chunk are the cosine and sine of the heading, never both 0")
    chunk[:, 0] = np.clip(chunk[:, 0], -1.0, 1.0)
    chunk[:, 3] = chunk[:, 3] > 0.5
    return chunk


def rows_to_execute(agent: Agent, chunk: ActionChunk) -> int:
    """How many rows to play before the agent is asked again.

    All of them, unless the agent has an attribute `execute_rows`: the remaining rows are then the fallback for a late
    answer. Raises AgentError when that is no whole number from 1.
    """
    wanted = getattr(agent, "execute_rows", len(chunk))
    if isinstance(wanted, bool) or not isinstance(wanted, Integral) or wanted < 1:
        raise AgentError(f"execute_rows is {wanted!r:.80}; it is a whole number of rows from 1")
    return min(int(wanted), len(chunk))


def world_action(row: Sequence[float] | Floats) -> tuple[float, float, float]:
    """One chunk row as `World.step` takes it for a seat: distance, heading [rad], toggle."""
    distance, heading, toggle = to_world(row).tolist()
    return distance, heading, toggle
