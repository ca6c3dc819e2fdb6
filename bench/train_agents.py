"""From nothing to trained agents and their table, by one command; each step that is done already is skipped.

    python -m bench.train_agents --data data --report docs/results.md

1. an expert plays with the people of populations A and B, its hand slipping now and then: episodes and labels;
2. Diffusion Policy (flow, fast denoiser) learns from them;
3. it plays with the same people while the expert labels (DAgger), and learns on; `--rounds` times;
4. the simulator of BASS learns from all these episodes;
5. everybody plays with the held-out people of population C, beside an idle partner and the scripted expert; the
   scores go into the cards and the table into the report.
"""

import argparse
import datetime
import os
import platform
from pathlib import Path

from agents.checkpoint import Score, find_checkpoint, rescored
from agents.populations import population
from bench.learning import Outcome, mean_error, play_all, runs, table
from maps import map_names
from server.cli import main as movingout

DP, BASS = "dp@all", "bass@all"


def main() -> None:
    """Parse and go through the steps."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path("data"), help="only ./data is seen by the worker processes")
    parser.add_argument("--episodes", type=int, default=24, help="per map in each round of labelling")
    parser.add_argument("--rounds", type=int, default=2, help="of labelling where the learner went")
    parser.add_argument(
        "--updates", type=int, default=8000, help="of the policy after the expert's round, and per round"
    )
    parser.add_argument("--width", type=int, default=512)
    parser.add_argument("--simulator-updates", type=int, default=8000)
    parser.add_argument("--runs", type=int, default=20, help="evaluation episodes per map and agent")
    parser.add_argument("--ticks", type=int, default=500)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--report", type=Path, default=Path("docs/results.md"))
    args = parser.parse_args()
    labels = args.data / "labels"
    for number in range(args.rounds + 1):
        learner = "scripted" if number == 0 else DP
        _label(args, labels / f"round-{number}", learner, seed=number)
        _train_policy(args, labels, total=args.updates * (number + 1))
    _train_simulator(args, labels)
    agents = [BASS, DP, "scripted", "idle"]
    people = [person.agent_id for person in population("C")]
    outcomes = play_all(runs(agents, people, list(map_names()), args.runs, args.ticks), args.workers)
    for agent_id in (DP, BASS):
        checkpoint = find_checkpoint(agent_id, args.data / "models")
        rescored(checkpoint, scores(outcomes, agent_id))
    args.report.write_text(report(outcomes, agents), encoding="utf-8")


def _label(args: argparse.Namespace, folder: Path, learner: str, seed: int) -> None:
    _command(
        "demos", "label", "--learner", learner, "--population", "AB", "--episodes", args.episodes, "--seed", seed,
        "--ticks", args.ticks, "--workers", args.workers, "--out", folder,
    )  # fmt: skip


def _train_policy(args: argparse.Namespace, labels: Path, total: int) -> None:
    """Go on to `total` updates with all labels there are."""
    _command(
        "train", "dp", labels, "--id", DP, "--data", args.data, "--updates", total, "--width", args.width,
        "--population", "scripted people A and B, labelled by the expert", "--name", "Diffusion Policy",
    )  # fmt: skip


def _train_simulator(args: argparse.Namespace, labels: Path) -> None:
    _command(
        "train", "bass", labels, "--id", BASS, "--base", DP, "--data", args.data,
        "--updates", args.simulator_updates, "--name", "BASS",
    )  # fmt: skip


def _command(*words: object) -> None:
    code = movingout([str(word) for word in words])
    if code != 0:
        raise SystemExit(code)


def scores(outcomes: list[Outcome], agent: str) -> dict[str, Score]:
    """TCR and NFD with unseen people, for a card."""
    mine = [one for one in outcomes if one.run.agent == agent]
    measured = {}
    for name in ("tcr", "nfd"):
        mean, error = mean_error([getattr(one, name) for one in mine])
        measured[f"{name} with unseen scripted people"] = Score(
            mean=round(mean, 4), stderr=round(error, 4), n=len(mine)
        )
    return measured


def report(outcomes: list[Outcome], agents: list[str]) -> str:
    """The page docs/results.md."""
    today = datetime.datetime.now(datetime.UTC).date().isoformat()
    lines = [
        "# Results",
        "",
        f"Made by `python -m bench.train_agents` on {today}, {platform.machine()}, {os.cpu_count()} cores.",
        "Partners are the held-out scripted people of population C; errors are standard errors over episodes.",
        "`idle` is the control: what the partners reach alone.",
        "",
        table(outcomes, agents, list(map_names())),
        "",
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    main()
