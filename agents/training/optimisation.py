"""How weights are fitted: the configuration that all methods share. Each method adds its own fields.

Every field becomes an option of `movingout train`. What is out of bounds is refused here, before anything is read.
"""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, Literal, TypeVar

from pydantic import BaseModel, Field, FiniteFloat, TypeAdapter, ValidationError

from movingout.agents.errors import DataError

Precision = Literal["auto", "bf16", "fp32"]
Compile = Literal["auto", "yes", "no"]
ModelT = TypeVar("ModelT", bound=BaseModel)

WORTH_COMPILING = 50_000  # updates
SAME_NAMES: Mapping[str, str] = MappingProxyType({})
AtLeastOne = Annotated[int, Field(ge=1)]
NotNegative = Annotated[int, Field(ge=0)]
NotNegativeFloat = Annotated[FiniteFloat, Field(ge=0.0)]
_adapters: dict[type[Any], TypeAdapter[Any]] = {}
Share = Annotated[FiniteFloat, Field(ge=0.0, lt=1.0)]


Change = Literal["free", "asked", "never"]
"""May a continued run have another value? `free`: yes; `asked`: with --go-on; `never`: it is another agent."""


def documented(default: Any, text: str, change: Change = "asked", before: object = None) -> Any:
    """A dataclass field with its help text; `before`: what was done by runs that are older than the field."""
    return field(default=default, metadata={"help": text, "change": change, "before": before})


@dataclass(frozen=True, kw_only=True)
class Optimisation:
    """How weights are fitted, for every network."""

    UNUSED: ClassVar[frozenset[str]] = frozenset()
    """Fields that do nothing in this training, and are no options of it."""

    updates: AtLeastOne = documented(6000, "gradient steps; ignored when epochs is set", "free")
    epochs: NotNegative = documented(
        0, "passes over the training windows instead of a number of updates; 0: use updates", "free"
    )
    batch: AtLeastOne = documented(1024, "windows per update")
    rate: Annotated[FiniteFloat, Field(gt=0.0)] = documented(
        1e-3, "peak learning rate of AdamW, reached after the warm-up, then a cosine to 0"
    )
    warmup: NotNegative = documented(200, "updates until the peak learning rate")
    decay: NotNegativeFloat = documented(1e-4, "weight decay")
    clip: NotNegativeFloat = documented(1.0, "largest norm of the gradient; 0: not clipped")
    ema: Share = documented(0.999, "decay of the moving average of the weights, which is what plays")
    held_out: Share = documented(0.1, "share of the participants kept for validation")
    seed: Annotated[int, Field(ge=0, lt=2**32)] = documented(0, "seed of initial weights, batches and noise")
    threads: Annotated[int, Field(ge=1, le=1024)] = documented(1, "CPU threads", "free")
    precision: Precision = documented(
        "auto",
        "bf16 (mixed precision), fp32, or auto: bf16 where it is faster: GPUs and processors with AVX512-BF16 or AMX",
        "free",
    )
    compile: Compile = documented(
        "auto",
        "yes: compile the losses first, which takes minutes and needs a C compiler; no: never; auto: only on a GPU "
        f"and for {WORTH_COMPILING:,} updates or more. Of no use to value networks and progress estimators",
        "free",
    )
    evaluate_every: AtLeastOne = documented(500, "updates between validations and resume files", "free")
    window_share: Annotated[FiniteFloat, Field(gt=0.0, le=1.0)] = documented(
        1.0, "share of the rows to use, for quick experiments"
    )

    def check(self) -> None:
        """Raises DataError for a field out of bounds."""
        try:
            _adapter(type(self)).validate_python(dataclasses.asdict(self))
        except ValidationError as error:
            raise DataError(invalid_field(error)) from error


def _adapter(kind: type[Any]) -> TypeAdapter[Any]:
    """The validator of a configuration; to make one takes 20 ms."""
    if kind not in _adapters:
        _adapters[kind] = TypeAdapter(kind)
    return _adapters[kind]


def described(model: type[ModelT], values: Mapping[str, object], options: Mapping[str, str] = SAME_NAMES) -> ModelT:
    """A description from its values; `options` maps fields to options with another name. Raises DataError."""
    try:
        return model.model_validate(values)
    except ValidationError as error:
        raise DataError(invalid_field(error, options)) from error


def invalid_field(error: ValidationError, options: Mapping[str, str] = SAME_NAMES) -> str:
    """The first error as a sentence: `--batch 0: input should be greater than or equal to 1`."""
    first = error.errors()[0]
    said = first["msg"].removeprefix("Value error, ")
    if not first["loc"]:
        return said
    name = str(first["loc"][0])
    return f"--{options.get(name, name).replace('_', '-')} {first['input']}: {said[0].lower()}{said[1:]}"
