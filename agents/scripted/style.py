"""How one scripted person plays: a handful of habits, drawn once per person and kept for all its episodes."""

from dataclasses import dataclass, fields, replace
from random import Random

from agents.errors import AgentError


@dataclass(frozen=True, slots=True)
class Style:
    """The habits. The defaults are an attentive, quick player."""

    heavy_first: bool = True  # starts with what needs two; otherwise with what one can carry
    far_first: bool = False  # fetches the farthest item first; otherwise the nearest
    patience: int = 60  # ticks to hold one end of a heavy item while nobody comes
    speed: float = 1.0  # stick deflection when driving straight on, in (0.3, 1]
    delay: int = 0  # ticks by which it sees the partner late
    noise: float = 0.0  # standard deviation of the steering error [rad], slowly changing
    hesitation: float = 0.0  # probability per tick of pausing for a third of a second
    detour: float = 0.0  # 0 to 1: how much it dislikes to pass close to walls

    def __post_init__(self) -> None:
        limits = {"patience": (5, 500), "speed": (0.3, 1.0), "delay": (0, 10), "noise": (0.0, 0.6)}
        limits |= {"hesitation": (0.0, 0.2), "detour": (0.0, 1.0)}
        for name, (low, high) in limits.items():
            value = getattr(self, name)
            if not low <= value <= high:
                raise AgentError(f"style: {name} must lie between {low} and {high}, not {value}")


def varied(seed: int) -> Style:
    """A person like the default one, with small differences that the seed decides; 0 is the default itself."""
    if seed == 0:
        return Style()
    random = Random(seed)
    return replace(
        Style(),
        heavy_first=random.random() < 0.8,
        patience=random.randint(40, 80),
        speed=random.uniform(0.92, 1.0),
        delay=random.choice((0, 0, 1, 2)),
        noise=random.uniform(0.0, 0.05),
        hesitation=random.uniform(0.0, 0.003),
    )


def style_names() -> tuple[str, ...]:
    """The fields that an agent id may set."""
    return tuple(field.name for field in fields(Style))
