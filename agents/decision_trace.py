"""What an agent tells about its last decision, as it is recorded and shown to spectators."""

from collections.abc import Mapping

import numpy as np
import orjson

from movingout.agents.base import Agent
from movingout.agents.fault_place import writable

UNWRITABLE = "unwritable"
"""The key under which a trace says why it cannot be written."""

MAX_PLAN = 200  # characters


def decision_trace(agent: Agent) -> Mapping[str, object]:
    """The agent's attribute `detail` as plain JSON values, arrays as lists; empty where it is not a mapping.

    What cannot be written as JSON is replaced by the reason, under `UNWRITABLE`.
    """
    try:
        detail = getattr(agent, "detail", None)
        if not isinstance(detail, Mapping):
            return {}
        plain: dict[str, object] = orjson.loads(orjson.dumps(dict(detail), _plain, orjson.OPT_SERIALIZE_NUMPY))
    except Exception as error:  # noqa: BLE001 - the code behind `detail` may be anybody's
        return {UNWRITABLE: writable(f"{type(error).__name__}: {error}")[:200]}
    return plain


def shown_part(trace: Mapping[str, object]) -> Mapping[str, object]:
    """What spectators see of a trace: all of one with candidates, of another its plan in words; empty for nothing.

    Prompts and answers of an agent with a plan are for the recording.
    """
    if "candidates" in trace:
        return trace
    plan = trace.get("plan")
    return {"plan": str(plan)[:MAX_PLAN]} if plan else {}


def _plain(value: object) -> object:
    """For what orjson cannot write itself: arrays that are not contiguous."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError
