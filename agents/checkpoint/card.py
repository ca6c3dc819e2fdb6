"""The card of a trained agent: who it is, where it comes from, what it is made of, how good it was. A strict schema."""

import math
from itertools import chain
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator

from movingout.agents.checkpoint.policy_spec import KindName, LayoutName, PolicySpec
from movingout.agents.errors import CheckpointError

MAX_FILE_BYTES = 256 << 20
FileName = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_-]{0,31}\.(onnx|safetensors|json)$")]
"""The name of a file beside the card; each agent kind has its own files."""

MAX_LINE = 400
OTHER_MAPS = "and others"
"""Among the maps of a card: it has no room for all; no map has such a name."""
_Line = Annotated[str, Field(max_length=MAX_LINE)]
_Sha256 = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
_Length = Annotated[int, Field(ge=0)] | Annotated[str, Field(max_length=60)]  # a word where it is left open
_Values = Annotated[dict[Annotated[str, Field(max_length=60)], tuple[_Length, ...]], Field(max_length=16)]
ID_WORD = "[a-z0-9][a-z0-9._-]{0,47}"
_AgentId = Annotated[str, Field(pattern=f"^{ID_WORD}(@{ID_WORD})?$")]
MAX_NAME = 60
MAX_POPULATION = 300  # characters; it is part of the description


class _StrictModel(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class FileEntry(_StrictModel):
    """One file of the folder, or of the folder of the agent `of` beside it: agents can have a network in common."""

    name: FileName
    bytes: Annotated[int, Field(ge=1, le=MAX_FILE_BYTES)]
    sha256: _Sha256
    of: _AgentId | None = None
    inputs: _Values | None = None  # of an ONNX file, with their shapes, as {"observation": ["batch", 1, 204]};
    outputs: _Values | None = None  # docs/learning.md says what they mean. None on older cards, and of other files


class Score(_StrictModel):
    """One measured mean, with its standard error over n episodes."""

    mean: float
    stderr: Annotated[float, Field(ge=0.0)]
    n: Annotated[int, Field(ge=1)]


class Training(_StrictModel):
    """Where the weights of a network come from."""

    preset: _Line
    data_sha256: _Sha256
    population: _Line
    episodes: Annotated[int, Field(ge=0)]
    windows: Annotated[int, Field(ge=0)]  # training rows: windows of a policy, ticks of a simulator, states of a value
    updates: Annotated[int, Field(ge=0)]  # in total, over all times the run was continued
    seed: int
    created: _Line  # ISO date
    items: Annotated[tuple[_Line, ...], Field(max_length=64)] | None = None
    """Sizes and shapes on the maps, "large star"; None where a part of the training is older than this field."""


Combine = Literal["independent", "product"]
SelectionScore = Literal["nfd", "nfd+ac", "value", "tcl"]
DynamicsKind = Literal["vae", "gru", "qvae"]


class SelectionSpec(_StrictModel):
    """How BASS chooses among candidates (paper, "Study on Action Sampling Times")."""

    own: Annotated[int, Field(ge=1, le=16)] = 4
    partner: Annotated[int, Field(ge=1, le=16)] = 4
    combine: Combine = "product"
    score: SelectionScore = "nfd"  # value: progress made, plus predicted further progress; tcl: learned without rewards
    depth: Annotated[int, Field(ge=1, le=32)] = 8  # ticks to simulate
    caution: Annotated[float, Field(ge=0.0, le=10.0)] = 0.0
    """A candidate is taken only if it is better than the first one by so many standard deviations of the ensemble."""
    simulator: Literal["learned", "engine"] = "learned"  # engine: the world's own, started from what is seen
    sub_steps: Literal[20, 10] = 20  # of the engine per simulated tick; the world itself makes 20


class DynamicsSpec(_StrictModel):
    """The shape of the learned simulator: two autoencoders around a latent step (paper, "BASS Details")."""

    kind: DynamicsKind = "vae"
    width: Annotated[int, Field(ge=4, le=2048)] = 128
    latent: Annotated[int, Field(ge=2, le=512)] = 32
    residual: bool = True  # decode the change of the state instead of the state
    rigid: bool = False  # held items move rigidly with the holder instead of being predicted
    grasping: bool = False  # the effect of a press is computed instead of predicted


class ValueSpec(_StrictModel):
    """The value network of BASS: discounted future progress."""

    width: Annotated[int, Field(ge=4, le=2048)] = 256
    members: Annotated[int, Field(ge=1, le=16)] = 1  # size of the ensemble; its mean is the value
    discount: Annotated[float, Field(gt=0.0, lt=1.0)] = 0.98  # per tick
    layout: LayoutName = "aware-v1"  # what it sees
    each: bool = False  # the graph gives the value of each member (B, members), not their mean (B,)


class ProgressSpec(_StrictModel):
    """The embedding whose distance from the start stands for progress (time-contrastive learning)."""

    width: Annotated[int, Field(ge=4, le=2048)] = 128
    latent: Annotated[int, Field(ge=2, le=512)] = 32


class Card(_StrictModel):
    """card.json."""

    schema_version: Literal[1]
    id: _AgentId
    name: Annotated[str, Field(min_length=1, max_length=MAX_NAME)]
    description: _Line
    kind: KindName
    maps: Annotated[tuple[_Line, ...], Field(min_length=1, max_length=64)]
    policy: PolicySpec | None = None  # of kinds that play by a policy network
    dynamics: DynamicsSpec | None = None
    selection: SelectionSpec | None = None
    value: ValueSpec | None = None
    progress: ProgressSpec | None = None
    training: Training  # of the policy; with BASS, of the base policy. Older cards lack the other two:
    dynamics_training: Training | None = None
    value_training: Training | None = None
    progress_training: Training | None = None
    scores: dict[Annotated[str, Field(max_length=60)], Score] = {}
    files: Annotated[tuple[FileEntry, ...], Field(min_length=1, max_length=8)]

    @property
    def learned_items(self) -> frozenset[str] | None:
        """`items` of all of its trainings; None where one does not say."""
        parts = (self.training, self.dynamics_training, self.value_training, self.progress_training)
        said = [part.items for part in parts if part is not None]
        return None if None in said else frozenset(chain.from_iterable(items for items in said if items is not None))

    @property
    def network(self) -> PolicySpec:
        """The shape of the policy network. Raises CheckpointError for an agent without one."""
        if self.policy is None:
            raise CheckpointError(f"{self.id} has no policy network")
        return self.policy

    @field_validator("scores")
    @classmethod
    def _finite(cls, scores: dict[str, Score]) -> dict[str, Score]:
        if not all(math.isfinite(score.mean) and math.isfinite(score.stderr) for score in scores.values()):
            raise ValueError("scores are finite numbers")
        return scores
