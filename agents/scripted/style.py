"""How a scripted person plays: a few habits, drawn once per person and kept for all episodes.

The habits in `PLAN_HABITS` affect planning and are applied by `ScriptedAgent`. The others describe perception and
motor control and are applied by `human_model.HumanModel`.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from random import Random
from typing import Any

from movingout.agents.errors import AgentError
from movingout.maps.suggestion import known_names

_LIMITS = {
    "patience": (5, 500),
    "speed": (0.3, 1.0),
    "delay": (0, 10),
    "noise": (0.0, 0.6),
    "hesitation": (0.0, 0.2),
    "detour": (0.0, 1.0),
    "help_after": (0, 60),
    "handover": (0.2, 0.8),
    "side": (-1.0, 1.0),
}
_CHOICES: dict[str, tuple[object, ...]] = {"role": ("equal", "leader", "follower"), "stick": (0, 8)}


@dataclass(frozen=True, slots=True)
class Style:
    """The habits of a person. The defaults are those of an attentive, quick one."""

    heavy_first: bool = True  # begins with items that need two, otherwise with those that one can carry
    far_first: bool = False  # fetches the farthest item first, otherwise the nearest
    patience: int = 60  # ticks to hold one end of a heavy item while the partner does not come
    detour: float = 0.0  # 0 to 1: preference for paths away from walls
    speed: float = 1.0  # stick deflection when driving straight on, in [0.3, 1]
    delay: int = 0  # ticks by which it sees the partner late
    noise: float = 0.0  # standard deviation of the steering error [rad], which changes slowly
    hesitation: float = 0.0  # probability per tick of pausing for a third of a second
    role: str = "equal"  # leader: minimises its own path; follower: adapts to the partner
    help_after: int = 0  # ticks until it helps a partner that holds a heavy item
    handover: float = 0.5  # where items are handed over in a lane: 0 at the goal, 1 at their start
    side: float = 0.0  # side it grabs from: 1 behind, to push the item to the goal; -1 ahead, to pull it
    stick: int = 0  # directions of the stick: 0 for any, 8 for keys, which have full deflection or none

    def __post_init__(self) -> None:
        for name, (low, high) in _LIMITS.items():
            value = getattr(self, name)
            if not isinstance(value, int | float) or not low <= value <= high:
                raise AgentError(f"style: {name} must lie between {low} and {high}, not {value}")
        for name, known in _CHOICES.items():
            if getattr(self, name) not in known:
                words = ", ".join(map(str, known))
                raise AgentError(f"style: {name} must be one of {words}, not {getattr(self, name)!r}")

    @property
    def habits(self) -> dict[str, Any]:
        """The habits by name, for fingerprints and files."""
        return asdict(self)


PLAN_HABITS = ("heavy_first", "far_first", "patience", "detour", "role", "help_after", "handover", "side")


def varied(seed: int, habits: Mapping[str, Any] | None = None) -> Style:
    """The default style with small random changes of plan habits, drawn by `seed`, and then with `habits`.

    Seed 0 is the default itself. Raises AgentError for a name that is not in `PLAN_HABITS`.
    """
    wrong = [name for name in habits or {} if name not in PLAN_HABITS]
    if wrong:
        raise AgentError(f"style: no habit {wrong[0]!r} of a plan; {known_names(wrong[0], PLAN_HABITS)}")
    return replace(Style() if seed == 0 else _drawn(seed), **dict(habits or {}))


def _drawn(seed: int) -> Style:
    random = Random(seed)
    return Style(
        heavy_first=random.random() < 0.8,
        far_first=random.random() < 0.1,
        patience=random.randint(40, 80),
        detour=random.choice((0.0, 0.0, 0.5)),
    )
