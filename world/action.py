"""The two forms of an action, and the only way from one to the other.

| form | numbers | used by |
|---|---|---|
| policy | distance, cos, sin, grasp | policies, agents, training data (paper, "Action Encoding") |
| world | distance, heading [rad], grasp | `World.step`, recordings, the wire |

Distance is forward or backward, nominally in [-1, 1]; heading 0 looks along +y, counter-clockwise; grasp 1 grabs or
lets go, 0 changes nothing. Everything that enters from outside is clipped and checked here, once.
"""

import math
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from movingout.world.errors import ActionError
from movingout.world.state import Floats

Rows = TypeVar("Rows", bound=npt.NDArray[np.floating[Any]])

POLICY_SIZE = 4  # distance, cos, sin, grasp
POLICY_LOW, POLICY_HIGH = (-1, -1, -1, 0), (1, 1, 1, 1)
WORLD_SIZE = 3  # distance, heading, grasp
GRASP_THRESHOLD = 0.5  # a grasp output above it is a press
AIMLESS = 1e-6  # a (cos, sin) shorter than it names no direction

# Equal actions are equal headings on every processor: NumPy's own arctan2 has other last bits where there is AVX-512.
_arctan2 = np.frompyfunc(math.atan2, 2, 1)


def to_world(policy: npt.ArrayLike) -> Floats:
    """Policy actions (..., 4) as world actions (..., 3): distance clipped, heading in (-pi, pi], grasp 0 or 1.

    The (cos, sin) pair need not have length 1; (0, 0) means heading 0. Raises ActionError for a wrong shape or a
    number that is not finite.
    """
    numbers = checked(policy, POLICY_SIZE)
    world = np.empty((*numbers.shape[:-1], WORLD_SIZE))
    world[..., 0] = np.maximum(np.minimum(numbers[..., 0], 1.0), -1.0)  # np.clip, in half the time
    world[..., 1] = _arctan2(numbers[..., 2], numbers[..., 1])
    world[..., 2] = numbers[..., 3] > GRASP_THRESHOLD
    return world


def to_policy(world: npt.ArrayLike) -> Floats:
    """World actions (..., 3) as policy actions (..., 4), clipped likewise; the inverse of `to_world`."""
    numbers = checked(world, WORLD_SIZE)
    policy = np.empty((*numbers.shape[:-1], POLICY_SIZE))
    policy[..., 0] = np.clip(numbers[..., 0], -1.0, 1.0)
    policy[..., 1] = np.cos(numbers[..., 1])
    policy[..., 2] = np.sin(numbers[..., 1])
    policy[..., 3] = numbers[..., 2] > GRASP_THRESHOLD
    return policy


def clipped(world: npt.ArrayLike) -> Floats:
    """World actions (..., 3) within bounds, for whatever comes from outside: distance in [-1, 1], grasp 0 or 1."""
    numbers = checked(world, WORLD_SIZE)
    legal = numbers.copy()
    np.clip(numbers[..., 0], -1.0, 1.0, out=legal[..., 0])
    legal[..., 2] = numbers[..., 2] > GRASP_THRESHOLD
    return legal


def turned(policy: Rows, angles: npt.ArrayLike) -> Rows:
    """Policy actions (..., 4 or more) with their headings turned by angles [rad], one or as many as their first axes.

    By the own angle, headings relative to the own become headings of the arena; by minus the own angle, the other way
    round.
    """
    shape = (*np.shape(angles), *[1] * (policy.ndim - 1 - np.ndim(angles)))
    cos, sin = (part.astype(policy.dtype).reshape(shape) for part in (np.cos(angles), np.sin(angles)))
    result = policy.copy()
    result[..., 1] = policy[..., 1] * cos - policy[..., 2] * sin
    result[..., 2] = policy[..., 1] * sin + policy[..., 2] * cos
    return result


def in_arena(policy: Floats, angle: float, own_frame: bool) -> Floats:
    """Actions (..., 4) that a policy chose for a robot at `angle` [rad], with headings of the arena.

    In an own frame, headings are relative to that angle. Where cos and sin are both 0, the robot keeps it.
    """
    aimless = np.hypot(policy[..., 1], policy[..., 2]) < AIMLESS
    rows = turned(policy, angle) if own_frame else policy
    if aimless.any():
        rows = rows.copy()
        rows[aimless, 1:3] = np.cos(angle), np.sin(angle)
    return rows


def checked(actions: npt.ArrayLike, size: int) -> Floats:
    """The actions as float64 (..., size), or an ActionError that says what is wrong with them."""
    try:
        numbers = np.asarray(actions, dtype=np.float64)
    except (TypeError, ValueError, RuntimeError) as error:  # the last for a tensor of torch that requires grad
        raise ActionError(f"an action is {size} numbers, not {actions!r:.80}: {error}") from error
    if numbers.ndim == 0 or numbers.shape[-1] != size:
        raise ActionError(f"an action is {size} numbers in the last axis; this has shape {numbers.shape}")
    if not np.isfinite(numbers).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(numbers))[0])
        raise ActionError(f"an action must be finite; the number at index {where} is {numbers[where]}")
    return numbers
