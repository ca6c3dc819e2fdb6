"""The shape of a policy as data: enough to rebuild its network, and nothing that could run code."""

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from movingout.world.observation import LAYOUTS
from movingout.world.observation.memory import MEMORY_SIZE

ACTION_WIDTH = 5
"""Per tick: distance, cos and sin of the heading, and the grasp one-hot (no, yes) as +1 and -1."""

KindName = Annotated[str, Field(pattern=r"^[a-z][a-z0-9-]{0,23}$")]
"""The name of an agent kind (`agents.kinds.registry`)."""
Grasp = Literal["hold", "toggle"]
LayoutName = Literal["official-v1", "map-v1", "aware-v1", "relative-v1", "image-v1"]
Lags = tuple[Annotated[int, Field(ge=1, le=100)], ...]
Denoiser = Literal["resmlp", "items", "unet", "cnn"]
Process = Literal["flow", "ddim", "ddpm"]


class PolicySpec(BaseModel):
    """A policy's kind and the numbers that shape its network. Bounds limit what a foreign card can ask for."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    kind: KindName
    layout: LayoutName
    lags: Annotated[Lags, Field(max_length=8)] = ()  # ticks back of what is remembered, see `world.observation.memory`
    obs_horizon: Annotated[int, Field(ge=1, le=8)]
    horizon: Annotated[int, Field(ge=1, le=32)]
    execute: Annotated[int, Field(ge=1, le=32)]
    grasp: Grasp = "hold"
    width: Annotated[int, Field(ge=4, le=4096)]
    depth: Annotated[int, Field(ge=1, le=16)]
    dropout: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.0
    denoiser: Denoiser = "resmlp"
    process: Process = "flow"
    train_steps: Annotated[int, Field(ge=1, le=1000)] = 36
    sample_steps: Annotated[int, Field(ge=1, le=1000)] = 4
    restless: Annotated[float, Field(ge=1.0, le=4.0)] = 1.0  # dp: factor on the sampling noise at a standstill
    latent: Annotated[int, Field(ge=0, le=64)] = 0  # numbers behind each observation that say who plays

    @model_validator(mode="after")
    def _can_be_built(self) -> Self:
        if self.execute > self.horizon:
            raise ValueError(f"of a horizon of {self.horizon} actions {self.execute} cannot be executed")
        if self.denoiser == "unet" and (self.horizon % 4 or self.width % 8):
            raise ValueError(
                "a U-Net halves its horizon twice and groups its channels by eight: "
                f"horizon {self.horizon} is to be a multiple of 4, width {self.width} of 8"
            )
        if (self.denoiser == "cnn") != (self.picture is not None):
            raise ValueError("--denoiser cnn and --layout image-v1 go together: it is the one that reads pictures")
        if self.denoiser == "items" and not LAYOUTS[self.layout].items:
            known = " and ".join(layout.name for layout in LAYOUTS.values() if layout.items)
            raise ValueError(f"denoiser items is for layouts {known}; other layouts take --denoiser resmlp")
        if self.own_frame and self.obs_horizon > 1:
            raise ValueError(f"layout {self.layout} remembers by --lags; leave --obs-horizon at 1")
        if self.latent and (self.obs_horizon > 1 or self.picture or self.denoiser == "unet"):
            raise ValueError("a latent goes with --obs-horizon 1, a layout of numbers and --denoiser items or resmlp")
        if self.lags and not self.own_frame:
            raise ValueError(f"--lags is for layouts in the own frame, not for {self.layout}; use --obs-horizon")
        return self

    @property
    def features(self) -> int:
        """D, the numbers of one observation, and of the latent behind it."""
        return LAYOUTS[self.layout].size + len(self.lags) * MEMORY_SIZE + self.latent

    @property
    def own_frame(self) -> bool:
        """Whether headings of actions are relative to the own heading, as in the observation."""
        return LAYOUTS[self.layout].own_frame

    @property
    def picture(self) -> tuple[int, int, int] | None:
        """Height, width and colours of an observation that is a picture."""
        return LAYOUTS[self.layout].picture
