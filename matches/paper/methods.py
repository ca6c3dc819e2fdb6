"""The agents of the paper's tables: which kind each is, what it is trained on, and with which options.

An id is a method, the episodes that it learns from, and from the second training on its seed: `dp@a`, `bass@c1-2`.
`c1` is all of Challenge 1, `a` and `b` are its two groups of participants, `c2` is Challenge 2. Who learns by
reinforcement learns from no episodes and on one map each: there `a` and `b` are two trainings with different seeds, and
`c2` plays varied maps.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

from movingout.maps import map_names
from movingout.maps.suggestion import known_names
from movingout.matches.errors import MatchError

DATA_SETS = ("c1", "a", "b", "c2")
POSE_NOISE = 0.002  # paper, "Behavior Augmentation and Recombination Sub-Trajectories"
NOISE_LEVELS = ("0.0002", "0.002", "0.02", "0.2")
NOISE_MAP = "SingleRotation"
PICTURE_MAP = "DistancePriority"  # paper: "We evaluated Map 6 using raw image inputs"
ORDER_MAPS = "PassOrSplit", "DistancePriority", "LeftRight"  # paper: "selected Maps 2, 6, & 9"
RECOMBINE = "--recombine", 0.25
AUGMENTED = "--pose-noise", POSE_NOISE, *RECOMBINE
SELECTION = "--score", "nfd", "--own", 4, "--partner", 4, "--combine", "independent", "--depth", 4
"""Paper: the NFD, of four independent pairs of samples. That it is the NFD after four ticks is ours."""
PICTURES = "--layout", "image-v1", "--denoiser", "cnn"
TCL = "--score", "tcl"  # after SELECTION, whose score it replaces


@dataclass(frozen=True, slots=True)
class Method:
    """How an agent is trained."""

    kind: str  # of `movingout train`
    options: tuple[Any, ...] = ()
    base: str = ""  # BASS: the method that proposes its candidates
    simulator: str = ""  # BASS: the method whose simulator it shares; empty: it trains its own
    maps: tuple[str, ...] = ()  # that it learns from; empty: all
    pictures: bool = False  # it learns from pictures: a quarter of the batch
    learns: bool = False  # BASS with a shared simulator: something else from episodes
    plays: bool = False  # learns from its own play, not from episodes; `maps` is where


def _bass(base: str, *options: Any, simulator: str = "") -> Method:
    return Method("bass", (*SELECTION, *options), base, simulator)


def _reinforced(kind: str, name: str, *options: Any) -> Method:
    return Method(kind, ("--map", name, *options), maps=(name,), plays=True)


ZSC_MAPS = 1, 12  # by number: those of the paper's comparison with zero-shot coordination
METHODS = {
    "mlp": Method("mlp"),
    "mlp-augmented": Method("mlp", AUGMENTED),
    "gru": Method("gru"),
    "gru-augmented": Method("gru", AUGMENTED),
    "dp": Method("dp"),
    "dp-augmented": Method("dp", AUGMENTED),
    "dp-recombined": Method("dp", RECOMBINE),
    "dp-recombined-single": Method("dp", (*RECOMBINE, "--matching", "either-end", "--confirm", "no")),
    **{f"dp-noise-{level}": Method("dp", ("--pose-noise", level), maps=(NOISE_MAP,)) for level in NOISE_LEVELS},
    "bass": _bass("dp-augmented"),
    "bass-plain": _bass("dp", simulator="bass"),
    "bass-on-gru": _bass("gru-augmented", simulator="bass"),
    "bass-on-gru-plain": _bass("gru", simulator="bass"),
    "bass-gru-dynamics": _bass("dp-augmented", "--dynamics", "gru"),
    "bass-qvae-dynamics": _bass("dp-augmented", "--dynamics", "qvae"),
    "bass-tcl": Method("bass", (*SELECTION, *TCL), "dp-augmented", "bass", learns=True),
    "dp-image": Method("dp", PICTURES, maps=(PICTURE_MAP,), pictures=True),
    "dp-image-augmented": Method("dp", (*PICTURES, *RECOMBINE), maps=(PICTURE_MAP,), pictures=True),
    "bass-image": Method("bass", (*SELECTION, *TCL), "dp-image-augmented", maps=(PICTURE_MAP,), pictures=True),
    "bass-joint": _bass("dp-augmented", "--residual", "no"),
    "bass-fine-tuned": _bass("dp-augmented", "--residual", "no", "--order", "fine-tuned"),
    "bass-separate": _bass("dp-augmented", "--residual", "no", "--order", "separate"),
    **{f"mappo-{number}": _reinforced("mappo", name) for number, name in enumerate(map_names(), start=1)},
    "mappo-6-sparse": _reinforced("mappo", map_names()[5], "--reward", "paper-sparse"),
    **{f"comedi-{number}": _reinforced("comedi", map_names()[number - 1]) for number in ZSC_MAPS},
}


class TrainedId(NamedTuple):
    """The parts of an id."""

    method: str
    data: str
    seed: int

    @property
    def text(self) -> str:
        return f"{self.method}@{self.data}" + (f"-{self.seed}" if self.seed else "")

    def of(self, method: str) -> "TrainedId":
        """Another method, trained on the same episodes with the same seed."""
        return self._replace(method=method)


def trained_id(agent_id: str) -> TrainedId:
    """The parts of an id, whose options (after a colon) do not count. Raises MatchError for one that is none."""
    reference = agent_id.partition(":")[0]
    method, _, place = reference.partition("@")
    data, _, seed = place.partition("-")
    if method not in METHODS or data not in DATA_SETS or not (seed or "0").isdecimal():
        known = [f"{name}@{data}" for name in METHODS for data in DATA_SETS]
        raise MatchError(f"{reference} is no agent of the paper; {known_names(reference, known)}")
    return TrainedId(method, data, int(seed or 0))


def with_seed(agent_id: str, seed: int) -> str:
    """The same agent of another training: `dp@a:lag=1` becomes `dp@a-2:lag=1`."""
    reference, colon, options = agent_id.partition(":")
    return trained_id(reference)._replace(seed=seed).text + colon + options


def trained_before(agent: TrainedId) -> Iterator[TrainedId]:
    """The agents that one is made of, each after those that it is made of itself."""
    method = METHODS[agent.method]
    for name in filter(None, (method.base, method.simulator)):
        yield from trained_before(agent.of(name))
        yield agent.of(name)
