"""Steps of a recipe: commands of `movingout`, each in a process of its own, that know whether they have been done."""

import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from movingout.agents.checkpoint.checkpoint import CARD, find_checkpoint, folder_name

Stage = tuple["TrainingStep", ...]
"""Steps that do not wait for each other; the next stage waits for all of them."""


def count_option(default: int, text: str, least: int = 1) -> Any:
    """A number of a recipe's sizes that may be chosen, with its help text and lowest value."""
    return field(default=default, metadata={"help": text, "least": least})


@dataclass(frozen=True, slots=True)
class TrainingStep:
    """One command."""

    words: tuple[str, ...]  # after `movingout`
    is_done: Callable[[], bool]
    marker: Path | None = None  # a file to leave when it has succeeded, where its own output does not tell
    agent_id: str = ""  # whom it trains
    log: Path | None = None  # where its output goes; None for the terminal


def trained(models: Path, agent_id: str, updates: int) -> Callable[[], bool]:
    """Whether a checkpoint has learned for as many updates, asked when a step is about to begin."""

    def is_done() -> bool:
        there = (models / folder_name(agent_id) / CARD).exists()
        return there and find_checkpoint(agent_id, models).card.training.updates >= updates

    return is_done


def run_stages(stages: Iterable[Stage], at_once: int) -> None:
    """Carry out what is not done yet, `at_once` steps of a stage at a time. Raises SystemExit when one fails."""
    for stage in stages:
        with ThreadPoolExecutor(at_once) as threads:
            waiting = [threads.submit(run_step, step) for step in stage]
            try:
                for done in as_completed(waiting):
                    done.result()
            except BaseException:
                threads.shutdown(wait=False, cancel_futures=True)  # when one fails, none is begun any more
                raise


def run_step(step: TrainingStep) -> None:
    """Carry out one step, unless it is done. Raises SystemExit, with the last words of its log, when it fails."""
    if step.is_done():
        return
    if step.log is None:
        code = _run(step, None)
        if code != 0:
            raise SystemExit(code)
    else:
        _run_logged(step, step.log)
    if step.marker is not None:
        step.marker.touch()


def _run_logged(step: TrainingStep, log: Path) -> None:
    log.parent.mkdir(parents=True, exist_ok=True)
    print(f"{step.agent_id}: training, its output is in {log}", flush=True)
    begun = time.monotonic()
    code = _run(step, log)
    if code != 0:
        last_words = log.read_text(encoding="utf-8")[-500:]
        raise SystemExit(f"{step.agent_id}: training ended with {code}: {last_words}")
    print(f"{step.agent_id}: trained after {time.monotonic() - begun:.0f} s", flush=True)


def _run(step: TrainingStep, log: Path | None) -> int:
    command = [sys.executable, "-P", "-m", "movingout.server.cli", *step.words]
    if log is None:
        return subprocess.run(command, check=False).returncode
    with log.open("a", encoding="utf-8") as file:
        return subprocess.run(command, stdout=file, stderr=subprocess.STDOUT, check=False).returncode
