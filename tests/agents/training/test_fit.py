"""The loop goes on where it was stopped, and says when there is nothing left to do."""

import contextlib
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import nn

from movingout.agents.errors import DataError
from movingout.agents.training.fit import FitResult, TrainingTask, _is_compiled, fit
from movingout.agents.training.gradients import Losses
from movingout.agents.training.optimisation import WORTH_COMPILING, Compile, Optimisation, Precision
from movingout.agents.training.run_folder import RESUME
from tests.recordings.full_disk import limited

CONFIG = Optimisation(rate=0.1, warmup=0, evaluate_every=2)


def _fit(folder: Path, updates: int, width: int = 3) -> FitResult[nn.Module]:
    """Learn to say nothing."""
    torch.manual_seed(0)

    def losses(network: nn.Module) -> Losses:
        return {"loss": network(torch.ones(4, 3)).square().mean()}

    task = TrainingTask(nn.Linear(3, width), losses, losses, updates, np.random.default_rng(0), 4)
    return fit(task, CONFIG, folder)


def test_what_was_stopped_goes_on(tmp_path: Path) -> None:
    assert _fit(tmp_path, 4).updates == 4
    longer = _fit(tmp_path, 7)
    curve = (tmp_path / "losses.jsonl").read_text().splitlines()
    assert longer.updates == 7 and len(curve) == 4  # at 2, 4, 6 and the end
    assert float(longer.network(torch.ones(1, 3)).abs().max()) < 1.0


@pytest.mark.filterwarnings("error::pytest.PytestUnhandledThreadExceptionWarning")  # of TensorBoard's own thread
@pytest.mark.parametrize("size", [50, 500, 3000])
def test_a_full_disk_ends_it_with_a_sentence_and_it_goes_on_from_there(size: int, tmp_path: Path) -> None:
    """Of TensorBoard's file, of the losses, or of what is saved."""
    _fit(tmp_path, 2)
    with limited(size), pytest.raises(DataError, match=r"cannot write .*; what was saved before is kept"):
        _fit(tmp_path, 40)
    assert _fit(tmp_path, 6).updates == 6
    curve = [json.loads(line)["update"] for line in (tmp_path / "losses.jsonl").read_text().splitlines()]
    assert curve == [2, 4, 6]


def _learned_from_noise(folder: Path, stop: int, with_draw: bool = False) -> torch.Tensor:
    """The weights after 6 updates with batches drawn from rows, and noise; interrupted once after `stop` of them."""
    material, left = torch.arange(24.0).reshape(8, 3), [stop]

    def run() -> FitResult[nn.Module]:
        random = np.random.default_rng(0)

        def draw() -> tuple[torch.Tensor]:
            return (material[random.choice(8, 4)],)

        def losses(network: nn.Module, *drawn: torch.Tensor) -> Losses:
            left[0] -= 1
            if left[0] < 0:
                raise KeyboardInterrupt
            (batch,) = drawn if with_draw else draw()
            return {"loss": (network(batch + torch.randn_like(batch)) - 1.0).square().mean()}

        torch.manual_seed(0)
        task = TrainingTask(
            nn.Linear(3, 1),
            losses,
            lambda _: {"loss": torch.zeros(())},
            6,
            random,
            8,
            draw if with_draw else None,
        )
        return fit(task, CONFIG, folder)

    with contextlib.suppress(KeyboardInterrupt):
        run()
    left[0] = 6
    return torch.cat([weights.flatten() for weights in run().network.state_dict().values()])


@pytest.mark.parametrize("save_seconds", [300.0, 0.0])
def test_what_was_stopped_comes_to_the_weights_of_what_was_not(
    save_seconds: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("movingout.agents.training.fit.SAVE_SECONDS", save_seconds)
    stopped, whole = (_learned_from_noise(tmp_path / str(stop), stop) for stop in (3, 6))
    assert torch.equal(stopped, whole)


def test_a_training_that_is_stopped_between_evaluations_has_been_saved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[int] = []

    def losses(network: nn.Module) -> Losses:
        made.append(len(made))
        if len(made) == 4:
            raise KeyboardInterrupt
        return {"loss": network(torch.ones(4, 3)).square().mean()}

    monkeypatch.setattr("movingout.agents.training.fit.SAVE_SECONDS", 0.0)
    task = TrainingTask(
        nn.Linear(3, 1), losses, lambda _: {"loss": torch.zeros(())}, 6, np.random.default_rng(0), rows=4
    )
    with pytest.raises(KeyboardInterrupt):
        fit(task, CONFIG, tmp_path)
    assert (fit(task, CONFIG, tmp_path).made, len(made)) == (3, 7)


def test_with_other_rows_it_goes_on_and_draws_anew(tmp_path: Path) -> None:
    def drawn(updates: int, rows: int) -> list[list[int]]:
        batches, random = [], np.random.default_rng(0)

        def losses(network: nn.Module) -> Losses:
            batches.append(random.choice(rows, 4).tolist())
            return {"loss": network(torch.ones(4, 3)).square().mean()}

        fit(
            TrainingTask(nn.Linear(3, 1), losses, lambda _: {"loss": torch.zeros(())}, updates, random, rows),
            CONFIG,
            tmp_path,
        )
        return batches

    first, more, other = drawn(2, 8), drawn(4, 8), drawn(6, 5)
    fresh = np.random.default_rng(0)
    assert first + more == [fresh.choice(8, 4).tolist() for _ in range(4)]
    fresh = np.random.default_rng(0)
    assert other == [fresh.choice(5, 4).tolist() for _ in range(2)]


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

    def losses(network: nn.Module) -> Losses:
        out = network(torch.ones(4, 3))
        seen.append(out.dtype)
        return {"loss": out.float().square().mean()}

    config = Optimisation(warmup=0, precision=precision)
    fitted = fit(
        TrainingTask(nn.Linear(3, 3), losses, lambda _: {"loss": torch.zeros(())}, 1, np.random.default_rng(0), 4),
        config,
        tmp_path,
    )
    assert seen == [expected]
    assert {parameter.dtype for parameter in fitted.network.parameters()} == {torch.float32}, "weights stay whole"


def test_it_does_not_matter_who_draws_a_batch(tmp_path: Path) -> None:
    within, before = (_learned_from_noise(tmp_path / str(way), 4, with_draw=way) for way in (False, True))
    assert torch.equal(within, before)


@pytest.mark.parametrize(
    ("compile_it", "on_gpu", "updates", "expected"),
    [
        ("auto", True, WORTH_COMPILING, True), ("auto", True, WORTH_COMPILING - 1, False),
        ("auto", False, WORTH_COMPILING, False), ("yes", False, 1, True), ("no", True, WORTH_COMPILING, False),
    ],
)  # fmt: skip
def test_long_trainings_on_a_gpu_are_compiled(compile_it: Compile, on_gpu: bool, updates: int, expected: bool) -> None:
    task = TrainingTask(nn.Linear(1, 1), lambda _: {}, lambda _: {}, updates, np.random.default_rng(0), 1, lambda: ())
    device, config = torch.device("cuda" if on_gpu else "cpu"), Optimisation(compile=compile_it)
    assert _is_compiled(task, config, device) == expected
    assert not _is_compiled(replace(task, draw=None), config, device), "drawing cannot be compiled"


def test_the_losses_that_are_compiled_are_those_of_the_task(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compiled = []

    def compile_them(losses: Callable[..., Losses], dynamic: bool) -> Callable[..., Losses]:
        compiled.append(losses)
        return losses

    monkeypatch.setattr(torch, "compile", compile_them)
    given = {"loss": torch.zeros((), requires_grad=True)}
    task = TrainingTask(
        nn.Linear(1, 1), lambda _: dict(given), lambda _: {}, 1, np.random.default_rng(0), 1, lambda: ()
    )
    fit(task, Optimisation(compile="yes"), tmp_path)
    assert compiled == [task.losses]
