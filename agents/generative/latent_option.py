"""The option `z` of a partner out of the generative model: its latent as text."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from movingout.agents.errors import AgentError

FARTHEST = 8.0  # of a number of a latent; what is learned lies within 3


def parsed_latent(text: str, size: int) -> npt.NDArray[np.float32]:
    """The latent (size,) that an option names. Raises AgentError."""
    try:
        numbers = [float(word) for word in text.split("/")]
    except ValueError:
        raise AgentError(f"z is {size} numbers joined by /, such as 0.3/-1.2/…, not {text!r}") from None
    if len(numbers) != size:
        raise AgentError(f"z has {size} numbers in this model, not {len(numbers)}: {text!r}")
    if not all(math.isfinite(number) and abs(number) <= FARTHEST for number in numbers):
        raise AgentError(f"the numbers of z lie between -{FARTHEST:g} and {FARTHEST:g}: {text!r}")
    return np.array(numbers, dtype=np.float32)


def latent_text(latent: npt.NDArray[np.floating[Any]]) -> str:
    """A latent as the option `z` takes it."""
    return "/".join(f"{number:.3f}" for number in latent.tolist())
