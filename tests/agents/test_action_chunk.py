"""The rim through which every answer of an agent goes."""

import gc

import numpy as np
import pytest
import torch

from movingout.agents.action_chunk import checked_chunk, rows_to_execute, world_action
from movingout.agents.errors import AgentError
from tests.agents.support import Forward


def test_a_good_chunk_is_clipped_and_its_toggles_made_whole() -> None:
    chunk = checked_chunk([[3.0, 0.0, 1.0, 0.9], [-2.0, 1.0, 0.0, 0.2]])
    np.testing.assert_array_equal(chunk, [[1.0, 0.0, 1.0, 1.0], [-1.0, 1.0, 0.0, 0.0]])
    assert world_action(chunk[0]) == (1.0, np.pi / 2, 1.0)


@pytest.mark.filterwarnings("error")
def test_a_tensor_is_taken_without_a_warning_and_left_as_it_is() -> None:
    answer = torch.tensor([[3.0, 1.0, 0.0, 0.0]], dtype=torch.float64)
    assert checked_chunk(answer).tolist() == [[1.0, 1.0, 0.0, 0.0]] and answer[0, 0] == 3.0


@pytest.mark.parametrize(
    ("answer", "sentence"),
    [
        (None, "act() returned None"),
        (1.0, "not ()"),
        ([1.0, 1.0, 0.0, 0.0], "not (4,)"),
        (np.zeros((0, 4)), "not (0, 4)"),
        ([[np.nan, 1.0, 0.0, 0.0]], "finite"),
        ([[1.0, 0.0, 0.0, 0.0]], "never both 0"),
        (
            torch.ones(1, 4, requires_grad=True),
            "which this Tensor is not: Can't call numpy() on Tensor that requires grad",
        ),
        ("forward", "which this str is not: could not convert string to float"),
    ],
)
def test_anything_else_is_refused_with_a_sentence(answer: object, sentence: str) -> None:
    with pytest.raises(AgentError) as raised:
        checked_chunk(answer)
    assert sentence in str(raised.value)


def test_an_agent_says_how_many_rows_to_play() -> None:
    chunk = np.tile([1.0, 1.0, 0.0, 0.0], (4, 1))
    assert rows_to_execute(Forward(4, 2), chunk) == 2
    assert rows_to_execute(Forward(4, 9), chunk) == 4


@pytest.mark.parametrize("wanted", [None, "2", 0, -1, 2.5, True])
def test_anything_but_a_whole_number_of_rows_is_refused(wanted: object) -> None:
    agent = Forward(4)
    agent.execute_rows = wanted  # type: ignore[assignment]
    with pytest.raises(AgentError, match=r"execute_rows is .*; it is a whole number of rows from 1"):
        rows_to_execute(agent, np.tile([1.0, 1.0, 0.0, 0.0], (4, 1)))
    agent.execute_rows = np.int64(2)  # type: ignore[assignment]
    assert rows_to_execute(agent, np.tile([1.0, 1.0, 0.0, 0.0], (4, 1))) == 2


async def _later() -> list[list[float]]:
    return [[1.0, 1.0, 0.0, 0.0]]


@pytest.mark.filterwarnings("error")
def test_a_coroutine_is_refused_and_closed() -> None:
    with pytest.raises(AgentError, match=r"act\(\) is async; nobody awaits its answer, so write a plain def"):
        checked_chunk(_later())
    gc.collect()  # where Python would say that it was never awaited
