"""From nothing to trained agents and their tables, by one command; each step that is done already is skipped.

    python -m bench.train_agents --data data --report docs/results.md

1. an expert plays with the people of populations A and B, its hand slipping now and then;
2. Diffusion Policy (flow, fast denoiser) learns from them;
3. it takes turns with the expert beside the same people (DAgger), and learns on; `--rounds` times;
4. MLP, GRU and Diffusion Policy with augmentation learn from the same labels;
5. Diffusion Policy plays with the same people, no expert helping; from all these episodes the simulator of BASS and a
   value to choose by are learned;
6. BASS plays with them, choosing by that value, and the value is learned again with these episodes too: a value knows
   little of where choosing by it leads before that was seen;
7. everybody plays with the people of A and B, and with those of population C whom nobody was trained with, beside an
   idle partner and the scripted expert; the scores with C go into the cards and the tables into the report.

Stopped and started again it goes on where it was; finished evaluation episodes are in DATA/evaluation.jsonl.
"""

import argparse
import os
import tempfile
from collections.abc import Sequence
from pathlib import Path

from agents.bass.agent import BassAgent
from agents.catalogue import load_agent
from agents.checkpoint import SHIPPED, Card, Score, find_checkpoint, folder_name, rescored
from agents.corrections import TEACHER
from agents.dataset import read_trajectories, recording_files
from agents.demonstrations import jobs, make_all
from agents.populations import population
from bench._agents_report import measured_part, write_report
from bench._roster import AUGMENTED, BASS, CONTROL, DP, FIRST, GRU, LEARNERS, MLP, PAPER_BASS, PLAIN, SCRIPTED
from bench.bass import Numbers, measure
from bench.learning import Outcome, finished, mean_error, play_all, runs
from maps import load_map, map_names
from server.cli import main as movingout

NAMES = {
    DP: "Diffusion Policy",
    AUGMENTED: "DP with augmentation",
    BASS: "DP/BASS",
    FIRST: "DP/BASS, its first value",
    PLAIN: "DP with simulation",
    MLP: "MLP",
    GRU: "GRU",
}
PEOPLE = "a scripted expert beside scripted people of A and B; none of population C"
AUGMENTATION = "--pose-noise", 0.002, "--recombine", 0.25  # paper, "Behavior Augmentation Details"
EVENT_WEIGHT = 4  # in the last updates: the hand changes in one window of ten, and everything hangs on when
GROUPS = {"C": "people of C, never trained with", "AB": "people of A and B, trained with"}


def main() -> None:
    """Parse and go through the steps."""
    args = _parsed()
    if not args.only_evaluate and not args.finished:
        _train_all(args)
    without = set(args.without.split(","))
    learners = {agent_id: label for agent_id, label in LEARNERS.items() if agent_id not in without}
    outcomes = _played(args, [*learners, SCRIPTED, CONTROL])
    cards: dict[str, Card] = {}
    for agent_id in learners:
        if ":" not in agent_id:
            checkpoint = find_checkpoint(agent_id, args.data / "models", SHIPPED)
            cards[agent_id] = rescored(checkpoint, scores(outcomes["C"], agent_id)).card
    numbers = None if args.no_parts else _parts_of_bass(args)
    by_partners = {GROUPS[group]: played for group, played in outcomes.items()}
    write_report(args.report, measured_part(by_partners, learners, cards, numbers))


def _played(args: argparse.Namespace, agents: list[str]) -> dict[str, list[Outcome]]:
    """All episodes by group of partners; each agent plays its first before any plays its second."""
    log = args.data / "evaluation.jsonl"
    todo = {group: runs(agents, _people(group), list(map_names()), args.runs, args.ticks) for group in GROUPS}
    in_turn = sorted((run for group in todo.values() for run in group), key=lambda run: run.seed)
    outcomes = finished(in_turn, log) if args.finished else play_all(in_turn, args.workers, log)
    done = {one.run: one for one in outcomes}
    return {group: [done[run] for run in made if run in done] for group, made in todo.items()}


def _people(group: str) -> list[str]:
    """The agent ids of the people of some populations, taken in turn."""
    populations = [population(name) for name in group]
    return [person.agent_id for people in zip(*populations, strict=True) for person in people]


def _parsed() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path("data"), help="only ./data is seen by the worker processes")
    parser.add_argument("--episodes", type=int, default=24, help="per map in the expert's round; half in the others")
    parser.add_argument("--rounds", type=int, default=2, help="of labelling where the learner went")
    parser.add_argument("--updates", type=int, default=4000, help="of the policy after each round of labelling")
    parser.add_argument("--last-updates", type=int, default=8000, help="more of them after the last round")
    parser.add_argument("--width", type=int, default=384)
    parser.add_argument("--simulator-updates", type=int, default=8000)
    parser.add_argument("--plays", type=int, default=18, help="episodes per map and population without the expert")
    parser.add_argument("--baseline-updates", type=int, default=4000)
    parser.add_argument("--without", default="", help="agents to leave out of the tables, joined by commas")
    parser.add_argument("--no-parts", action="store_true", help="leave out the section on the parts of BASS")
    parser.add_argument("--only-evaluate", action="store_true", help="what is trained is good enough")
    parser.add_argument("--finished", action="store_true", help="tables of what was played so far; plays no more")
    parser.add_argument("--runs", type=int, default=10, help="evaluation episodes per map and agent")
    parser.add_argument("--ticks", type=int, default=500)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--report", type=Path, default=Path("docs/results.md"))
    return parser.parse_args()


def _train_all(args: argparse.Namespace) -> None:
    labels = args.data / "labels"
    for number in range(args.rounds + 1):
        learner, count = (TEACHER, args.episodes) if number == 0 else (DP, max(args.episodes // 2, 1))
        _label(args, labels / f"round-{number}", learner, count, seed=number)
        _train_policy(args, labels, args.updates * (number + 1))
    first = args.updates * (args.rounds + 1)
    for agent_id, words in ((DP, ()), (AUGMENTED, AUGMENTATION)):
        _train_policy(args, labels, first, *words, agent_id=agent_id)
        _train_policy(
            args, labels, first + args.last_updates, *words, "--event-weight", EVENT_WEIGHT, agent_id=agent_id
        )
    for kind, agent_id in (("mlp", MLP), ("gru", GRU)):
        _train(args, agent_id, kind, labels, "--population", PEOPLE, "--updates", args.baseline_updates)
    plays = _plays(args, DP)
    _train(args, FIRST, "bass", labels, plays, "--base", AUGMENTED, "--updates", args.simulator_updates)
    again = _plays(args, FIRST)
    _train(args, BASS, "bass", labels, plays, again, "--base", AUGMENTED, "--simulator", FIRST)
    _train(args, PLAIN, "bass", "--base", DP, "--simulator", BASS, "--value", BASS)


def _train(args: argparse.Namespace, agent_id: str, kind: str, *words: object) -> None:
    """Train an agent that is not there yet."""
    if not (args.data / "models" / folder_name(agent_id)).exists():
        _command("train", kind, *words, "--data", args.data, "--id", agent_id, "--name", NAMES[agent_id])


def _plays(args: argparse.Namespace, agent_id: str) -> Path:
    """The folder of episodes in which an agent plays with people of A and B, in either seat, and nobody helps it."""
    folder: Path = args.data / "plays" / folder_name(agent_id)
    for number, (people, red) in enumerate((people, red) for people in "AB" for red in (True, False)):
        seats = (agent_id, f"people:{people}") if red else (f"people:{people}", agent_id)
        if not (folder / f"done-{number}").exists():
            _command(
                "match", "--red", seats[0], "--blue", seats[1], "--episodes", -(-args.plays // 2),
                "--seed", 1000 * number,
                "--ticks", args.ticks, "--workers", args.workers, "--record", folder / f"{number}",
            )  # fmt: skip
            (folder / f"done-{number}").touch()
    return folder


def _label(args: argparse.Namespace, folder: Path, learner: str, episodes: int, seed: int) -> None:
    if (folder / "done").exists():
        return
    _command(
        "demos", "label", "--learner", learner, "--population", "AB", "--episodes", episodes, "--seed", seed,
        "--ticks", args.ticks, "--workers", args.workers, "--out", folder,
    )  # fmt: skip
    (folder / "done").touch()


def _train_policy(args: argparse.Namespace, labels: Path, total: int, *words: object, agent_id: str = DP) -> None:
    """Go on to `total` updates with all labels there are; nothing to do when the card says as many."""
    folder = args.data / "models" / folder_name(agent_id)
    if folder.exists() and find_checkpoint(agent_id, args.data / "models").card.training.updates >= total:
        return
    _command(
        "train", "dp", labels, "--id", agent_id, "--data", args.data, "--updates", total, "--width", args.width,
        "--population", PEOPLE, "--name", NAMES[agent_id], *words,
    )  # fmt: skip


def _command(*words: object) -> None:
    code = movingout([str(word) for word in words])
    if code != 0:
        raise SystemExit(code)


def _parts_of_bass(args: argparse.Namespace) -> Numbers:
    """Next state, partner prediction and selection on one episode of C per map."""
    agent = load_agent(PAPER_BASS)
    assert isinstance(agent, BassAgent)
    maps = [load_map(name) for name in map_names()]
    with tempfile.TemporaryDirectory() as folder:
        todo = jobs(population("C")[:2], maps, 1, args.ticks, seed=0, prefix="parts")
        list(make_all(todo, Path(folder), args.workers))
        return measure(agent, read_trajectories(recording_files([Path(folder)])), moments=20, seed=0)


def scores(outcomes: Sequence[Outcome], agent: str) -> dict[str, Score]:
    """TCR and NFD with unseen people for a card, and the TCR of these people with the control."""
    mine = [one for one in outcomes if one.run.agent == agent]
    control = [one for one in outcomes if one.run.agent == CONTROL]
    measured = {
        f"{name.upper()} with unseen scripted people": _score([getattr(one, name) for one in mine])
        for name in ("tcr", "nfd")
    }
    if control:
        measured["TCR of these people with an idle partner"] = _score([one.tcr for one in control])
    return measured


def _score(values: list[float]) -> Score:
    mean, error = mean_error(values)
    return Score(mean=round(mean, 4), stderr=round(error, 4), n=len(values))


if __name__ == "__main__":
    main()
