"""Recurrent policies as ONNX: memory is carried from decision to decision, and starts anew with each episode."""

import warnings
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor, nn

from movingout.agents.base import Agent, EpisodeInfo
from movingout.agents.catalogue import load_agent
from movingout.agents.conformance import check_agent
from movingout.agents.errors import AgentError
from movingout.agents.observation.seat_observation import observe, start_state
from movingout.maps import load_map
from movingout.world.observation import encode_state

MAP = load_map("HandOff")
WIDTH = 169


class Recurrent(nn.Module):
    """An LSTM of two layers that is given its memory, as it is exported for play."""

    def __init__(self) -> None:
        super().__init__()
        torch.manual_seed(0)
        self.lstm = nn.LSTM(WIDTH, 16, num_layers=2)
        self.head = nn.Linear(16, 4)

    def forward(self, seen: Tensor, hidden: Tensor, cell: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Observations (batch, D), memory (layers, batch, 16)."""
        out, (hidden, cell) = self.lstm(seen[None], (hidden, cell))
        return self.head(out[0]), hidden, cell


class Forgetful(Recurrent):
    def forward(self, seen: Tensor, hidden: Tensor, cell: Tensor) -> tuple[Tensor, Tensor]:  # type: ignore[override]
        answer, hidden, _ = super().forward(seen, hidden, cell)
        return answer, hidden


Recurrence = type[nn.LSTM | nn.GRU | nn.RNN]


class Within(nn.Module):
    """A recurrent network over the last observations, with no memory outside."""

    def __init__(self, network: nn.LSTM | nn.GRU | nn.RNN) -> None:
        super().__init__()
        self.network, self.head = network, nn.Linear(16, 4)

    def forward(self, seen: Tensor) -> Tensor:
        answer: Tensor = self.head(self.network(seen)[0][:, -1])
        return answer


def exported(module: nn.Module, path: Path, example: tuple[Tensor, ...], inputs: list[str], outputs: list[str]) -> Path:
    batch = {name: {1 if name.startswith(("hidden", "cell")) else 0: "batch"} for name in (*inputs, *outputs)}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about the newer exporter
        torch.onnx.export(
            module.eval(), example, path, input_names=inputs, output_names=outputs, dynamic_axes=batch,
            opset_version=17, dynamo=False,
        )  # fmt: skip
    return path


def recurrent(module: nn.Module, path: Path, outputs: int = 3) -> Path:
    memory = torch.zeros(2, 1, 16)
    names = ["action", "hidden_out", "cell_out"][:outputs]
    return exported(module, path, (torch.zeros(1, WIDTH), memory, memory), ["seen", "hidden", "cell"], names)


def answers(agent: Agent, ticks: int) -> list[list[float]]:
    agent.reset(EpisodeInfo(MAP, 0, seed=0, ticks=500))
    state = start_state(MAP)
    return [np.round(agent.act(observe(MAP, state, 0, tick))[0], 5).tolist() for tick in range(ticks)]


def test_memory_is_carried_on_and_starts_anew_with_an_episode(tmp_path: Path) -> None:
    module = Recurrent()
    agent = load_agent(f"onnx:path={recurrent(module, tmp_path / 'lstm.onnx')}")
    seen = torch.tensor(encode_state(MAP, start_state(MAP), 0, "map-v1"), dtype=torch.float32)[None]
    hidden = cell = torch.zeros(2, 1, 16)
    wanted = []
    with torch.inference_mode():
        for _ in range(3):
            answer, hidden, cell = module(seen, hidden, cell)
            wanted.append(answer[0].numpy())
    assert np.allclose(np.array(answers(agent, 3))[:, :3], np.array(wanted)[:, :3], atol=1e-4)
    assert np.abs(wanted[0] - wanted[1]).max() > 1e-3
    assert answers(agent, 3) == answers(agent, 3)
    check_agent(lambda: load_agent(f"onnx:path={tmp_path / 'lstm.onnx'}"), ["HandOff"], 10)


def test_memory_that_is_not_given_back_is_refused(tmp_path: Path) -> None:
    file = recurrent(Forgetful(), tmp_path / "p.onnx", outputs=2)
    with pytest.raises(AgentError, match=r"takes hidden \[2, 1, 16\], cell .* gives such a memory back"):
        load_agent(f"onnx:path={file}")


@pytest.mark.parametrize("kind", [nn.LSTM, nn.GRU, nn.RNN])
def test_a_recurrent_network_over_the_last_observations_plays(
    tmp_path: Path, kind: type[nn.LSTM | nn.GRU | nn.RNN]
) -> None:
    example = (torch.zeros(1, 4, WIDTH),)
    file = exported(Within(kind(WIDTH, 16, batch_first=True)), tmp_path / "p.onnx", example, ["seen"], ["action"])
    assert answers(load_agent(f"onnx:path={file}"), 2)
