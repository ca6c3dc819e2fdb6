"""What is trained, from what and in which order; a step that is done already is skipped.

What does not wait for each other is trained at the same time, in as many processes as there are workers; what they
say goes to data/logs/<agent>.log.
"""

import argparse
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from functools import partial
from pathlib import Path
from typing import NamedTuple

from bench._roster import (
    AUGMENTED,
    AUGMENTED_A,
    BASS,
    BASS_A,
    DP,
    DP_A,
    FIRST,
    GRU,
    GRU_A,
    LEARNER,
    MLP,
    MLP_A,
    PLAIN,
    PLAIN_A,
)
from movingout.agents.checkpoint.checkpoint import CARD, find_checkpoint, folder_name
from movingout.agents.data.dagger import TEACHER
from movingout.server.cli import main as movingout

NAMES = {
    LEARNER: "Diffusion Policy between the rounds",
    DP: "Diffusion Policy",
    AUGMENTED: "DP with augmentation",
    BASS: "DP/BASS",
    PLAIN: "DP with simulation",
    FIRST: "DP/BASS, its first value",
    MLP: "MLP",
    GRU: "GRU",
    DP_A: "Diffusion Policy, A alone",
    AUGMENTED_A: "DP with augmentation, A alone",
    BASS_A: "DP/BASS, A alone",
    PLAIN_A: "DP with simulation, A alone",
    MLP_A: "MLP, A alone",
    GRU_A: "GRU, A alone",
}
AUGMENTATION = "--pose-noise", 0.002, "--recombine", 0.25  # paper, "Behavior Augmentation Details"
BY_NFD = "--score", "nfd", "--own", 4, "--partner", 4  # paper, 4 x 4 sampling


class Lessons(NamedTuple):
    """Labelled episodes to learn from, and whose they are."""

    folder: Path
    people: str


def train_all(args: argparse.Namespace) -> None:
    """Every agent of the tables, from nothing."""
    labels = args.data / "labels"
    both = Lessons(labels, "a scripted expert beside scripted people of A and B; none of population C")
    only_a = Lessons(labels / "a", "a scripted expert beside scripted people of A; none of populations B and C")
    alone = "--threads", args.workers  # of what has the machine for itself
    for number in range(args.rounds + 1):
        for people in "AB":
            _label(args, labels / people.lower() / f"round-{number}", people, number)
        if number < args.rounds:
            _train_policy(args, both, LEARNER, args.updates * (number + 1), *alone)
    simulator = "--updates", args.simulator_updates
    of_both = _diffusion(args, both, args.policy_updates, DP, AUGMENTED)
    of_a = _diffusion(args, only_a, args.policy_updates // 2, DP_A, AUGMENTED_A)  # half of the labels
    _together(args, [*of_both, *of_a])
    plays = _plays(args, DP)
    first = partial(_train, args, FIRST, "bass", labels, plays, "--base", DP, *simulator)
    bass_a = partial(_train, args, BASS_A, "bass", only_a.folder, "--base", AUGMENTED_A, *BY_NFD, *simulator)
    # nothing waits for the baselines, so they fill what the first value leaves of the processor
    _together(args, [first, bass_a, *_baselines(args, both, MLP, GRU), *_baselines(args, only_a, MLP_A, GRU_A)])
    again = _plays(args, FIRST)
    _train(args, PLAIN, "bass", labels, plays, again, "--base", DP, "--simulator", FIRST, *alone)
    _train(args, BASS, "bass", "--base", AUGMENTED, "--simulator", PLAIN, "--value", PLAIN)
    _train(args, PLAIN_A, "bass", "--base", DP_A, "--simulator", BASS_A, *BY_NFD)


Step = Callable[[], None]


def _together(args: argparse.Namespace, steps: Sequence[Step]) -> None:
    """As many steps at a time as there are workers; when one fails, none is begun any more."""
    with ThreadPoolExecutor(args.workers) as threads:
        waiting = [threads.submit(step) for step in steps]
        try:
            for done in as_completed(waiting):
                done.result()
        except BaseException:
            threads.shutdown(wait=False, cancel_futures=True)
            raise


def _diffusion(args: argparse.Namespace, lessons: Lessons, updates: int, dp: str, augmented: str) -> list[Step]:
    """Diffusion Policy without and with augmentation from the same lessons."""
    return [
        partial(_train_policy, args, lessons, dp, updates),
        partial(_train_policy, args, lessons, augmented, updates, *AUGMENTATION),
    ]


def _baselines(args: argparse.Namespace, lessons: Lessons, mlp: str, gru: str) -> list[Step]:
    """The paper's two baselines from the same lessons, the longer one first."""
    words = lessons.folder, "--population", lessons.people, "--updates", args.baseline_updates
    return [partial(_train, args, gru, "gru", *words), partial(_train, args, mlp, "mlp", *words)]


def _label(args: argparse.Namespace, folder: Path, people: str, number: int) -> None:
    """A round of labelling beside the people of one population; the learner is a policy of both."""
    if (folder / "done").exists():
        return
    learner, count = (TEACHER, args.episodes) if number == 0 else (LEARNER, max(args.episodes // 2, 1))
    _movingout(
        "demos", "label", "--learner", learner, "--population", people, "--episodes", -(-count // 2), "--seed", number,
        "--ticks", args.ticks, "--workers", args.workers, "--out", folder,
    )  # fmt: skip
    (folder / "done").touch()


def _plays(args: argparse.Namespace, agent_id: str) -> Path:
    """The folder of episodes in which an agent plays with people of A and B, in either seat, and nobody helps it."""
    folder: Path = args.data / "plays" / folder_name(agent_id)
    for number, (people, red) in enumerate((people, red) for people in "AB" for red in (True, False)):
        seats = (agent_id, f"people:{people}") if red else (f"people:{people}", agent_id)
        if not (folder / f"done-{number}").exists():
            _movingout(
                "match", "--red", seats[0], "--blue", seats[1], "--episodes", -(-args.plays // 2),
                "--seed", 1000 * number,
                "--ticks", args.ticks, "--workers", args.workers, "--record", folder / f"{number}",
            )  # fmt: skip
            (folder / f"done-{number}").touch()
    return folder


def _train_policy(args: argparse.Namespace, lessons: Lessons, agent_id: str, total: int, *words: object) -> None:
    """Go on to `total` updates with all labels there are by now; nothing to do when the card says as many."""
    folder = args.data / "models" / folder_name(agent_id)
    if (folder / CARD).exists() and find_checkpoint(agent_id, args.data / "models").card.training.updates >= total:
        return
    sizes = "--go-on", "--updates", total, "--width", args.width, "--batch", args.batch
    _command(args, agent_id, "train", "dp", lessons.folder, *sizes, "--population", lessons.people, *words)


def _train(args: argparse.Namespace, agent_id: str, kind: str, *words: object) -> None:
    """Train an agent that is not there yet."""
    if not (args.data / "models" / folder_name(agent_id) / CARD).exists():
        _command(args, agent_id, "train", kind, *words)


def _command(args: argparse.Namespace, agent_id: str, *words: object) -> None:
    """Train in a process of its own. Raises SystemExit with its last words when it fails."""
    log = args.data / "logs" / f"{folder_name(agent_id)}.log"
    log.parent.mkdir(parents=True, exist_ok=True)
    print(f"{agent_id}: training, what it says is in {log}", flush=True)
    begun = time.monotonic()
    with log.open("a", encoding="utf-8") as file:
        about = "--id", agent_id, "--name", NAMES[agent_id], "--data", args.data
        command = [sys.executable, "-m", "movingout.server.cli", *map(str, (*words, *about))]
        code = subprocess.run(command, stdout=file, stderr=subprocess.STDOUT, check=False).returncode
    if code != 0:
        raise SystemExit(f"{agent_id}: training ended with {code}: {log.read_text(encoding='utf-8')[-500:]}")
    print(f"{agent_id}: trained after {time.monotonic() - begun:.0f} s", flush=True)


def _movingout(*words: object) -> None:
    code = movingout([str(word) for word in words])
    if code != 0:
        raise SystemExit(code)
