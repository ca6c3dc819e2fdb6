"""What an agent tells about its decision comes out as plain values."""

from typing import Any

import numpy as np
import pytest

from movingout.agents.decision_trace import decision_trace


class _Telling:
    def __init__(self, detail: Any) -> None:
        self.detail = detail

    reset = act = None


class _Refusing:
    @property
    def detail(self) -> Any:
        raise OSError("caf\udce9.txt")

    reset = act = None


@pytest.mark.parametrize(
    ("detail", "trace"),
    [
        (None, {}),
        ({"scores": np.array([0.5, 1.5]), "best": np.int64(1)}, {"scores": [0.5, 1.5], "best": 1}),
        ({"way": (1, 2)}, {"way": [1, 2]}),
        ({"column": np.eye(2)[:, 0], "half": np.float16(1.5)}, {"column": [1.0, 0.0], "half": 1.5}),
        ({1: 2}, {"unwritable": "TypeError: Dict key must be str"}),
        ({"raw": b"x"}, {"unwritable": "TypeError: Type is not JSON serializable: bytes"}),
        ({"many": 2**64}, {"unwritable": "TypeError: Integer exceeds 64-bit range"}),
    ],
)
def test_a_trace_is_plain_values_or_the_reason_why_not(detail: Any, trace: dict[str, object]) -> None:
    assert decision_trace(_Telling(detail)) == trace  # type: ignore[arg-type]


def test_the_reason_can_be_written_itself() -> None:
    assert decision_trace(_Refusing()) == {"unwritable": "OSError: caf\\udce9.txt"}  # type: ignore[arg-type]
