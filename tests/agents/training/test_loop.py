"""The loop goes on where it was stopped, and says when there is nothing left to do."""

import contextlib
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import nn

from agents.errors import DataError
from agents.training.config import Optimisation, Precision
from agents.training.loop import Fitted, Losses, Task, fit
from agents.training.run import RESUME

CONFIG = Optimisation(rate=0.1, warmup=0, evaluate_every=2)


def _fit(folder: Path, updates: int, width: int = 3) -> Fitted[nn.Module]:
    """Learn to say nothing."""
    torch.manual_seed(0)

    def losses(network: nn.Module, random: np.random.Generator) -> Losses:
        return validate(network)

    def validate(network: nn.Module) -> Losses:
        return {"loss": network(torch.ones(4, 3)).square().mean()}

    return fit(Task(nn.Linear(3, width), losses, validate, updates), CONFIG, folder)


def test_what_was_stopped_goes_on(tmp_path: Path) -> None:
    assert _fit(tmp_path, 4).updates == 4
    longer = _fit(tmp_path, 7)
    curve = (tmp_path / "losses.jsonl").read_text().splitlines()
    assert longer.updates == 7 and len(curve) == 4  # at 2, 4, 6 and the end
    assert float(longer.network(torch.ones(1, 3)).abs().max()) < 1.0


def test_what_was_stopped_comes_to_the_weights_of_what_was_not(tmp_path: Path) -> None:
    def trained(folder: Path, stop: int) -> torch.Tensor:
        """Learn from noise, in batches drawn from rows; stopped once before update `stop`."""
        rows, left = torch.arange(24.0).reshape(8, 3), [stop]

        def losses(network: nn.Module, random: np.random.Generator) -> Losses:
            left[0] -= 1
            if left[0] < 0:
                raise KeyboardInterrupt
            batch = rows[random.choice(8, 4)]
            return {"loss": (network(batch + torch.randn_like(batch)) - 1.0).square().mean()}

        torch.manual_seed(0)
        network = nn.Linear(3, 1)
        with contextlib.suppress(KeyboardInterrupt):
            fit(Task(network, losses, lambda _: {"loss": torch.zeros(())}, 6), CONFIG, folder)
        left[0] = 6
        fitted = fit(Task(network, losses, lambda _: {"loss": torch.zeros(())}, 6), CONFIG, folder)
        return torch.cat([weights.flatten() for weights in fitted.network.state_dict().values()])

    assert torch.equal(trained(tmp_path / "stopped", 3), trained(tmp_path / "whole", 6))


def test_nothing_is_done_twice_and_it_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first = _fit(tmp_path, 4)
    assert "already trained" not in capsys.readouterr().err
    for updates in (4, 2):
        again = _fit(tmp_path, updates)
        assert (again.updates, again.made) == (4, 0)
        assert torch.equal(again.network(torch.ones(1, 3)), first.network(torch.ones(1, 3)))
        assert f"{tmp_path}: already trained 4 updates; nothing is left to do" in capsys.readouterr().err


def test_a_resume_file_that_is_damaged_or_of_another_network_is_refused(tmp_path: Path) -> None:
    _fit(tmp_path, 2)
    with pytest.raises(DataError, match="another network; choose another --id"):
        _fit(tmp_path, 4, width=2)
    (tmp_path / RESUME).write_bytes(b"nothing of the kind")
    with pytest.raises(DataError, match="is damaged"):
        _fit(tmp_path, 4)


@pytest.mark.parametrize(
    ("precision", "bf16_here", "expected"),
    [("auto", True, torch.bfloat16), ("auto", False, torch.float32), ("fp32", True, torch.float32)],
)
def test_precision_goes_by_what_the_processor_has(
    precision: Precision, bf16_here: bool, expected: torch.dtype, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(torch.cpu, "_is_avx512_bf16_supported", lambda: bf16_here)
    monkeypatch.setattr(torch.cpu, "_is_amx_tile_supported", lambda: False)
    seen: list[torch.dtype] = []

    def losses(network: nn.Module, random: np.random.Generator) -> Losses:
        out = network(torch.ones(4, 3))
        seen.append(out.dtype)
        return {"loss": out.float().square().mean()}

    config = Optimisation(warmup=0, precision=precision)
    fitted = fit(Task(nn.Linear(3, 3), losses, lambda _: {"loss": torch.zeros(())}, 1), config, tmp_path)
    assert seen == [expected]
    assert {parameter.dtype for parameter in fitted.network.parameters()} == {torch.float32}, "weights stay whole"
