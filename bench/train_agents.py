"""Train all agents from scratch, evaluate them and write their tables; finished steps are skipped.

    python -m bench.train_agents --report docs/twelve-maps.md

1. an expert plays with the people of populations A and B, with occasional slips of its hand;
2. a Diffusion Policy (flow, fast denoiser) is trained on these episodes;
3. it takes turns with the expert beside the same people (DAgger) and is trained further; `--rounds` times;
4. MLP, GRU and Diffusion Policy, with and without augmentation, are trained from scratch on all labels;
5. Diffusion Policy plays with the same people, without the expert; BASS's simulator and a value function are trained on
   all these episodes;
6. BASS plays with them, choosing by that value, and the value is trained again with these episodes added: it cannot
   judge states that choosing by it leads to before it has seen them;
7. the policies and the paper's BASS, choosing by NFD, are trained again with people of A alone;
8. all agents, an idle partner and the scripted expert play with people of population C, with whom no agent was trained;
   those trained with A alone also play with A and B. The scores with C go into the model cards, the tables into the
   report.

Steps 1 to 7 are `agents.curriculum.recipe`; `--dry-run` prints their commands. A restarted command resumes where it
stopped; finished evaluation episodes are in data/evaluation.jsonl.
"""

import argparse
import dataclasses
import os
import shlex
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from bench._roster import CHOOSING_BY_NFD, CONTROL, OF_A, OF_BOTH, PAPER_BASS, SCRIPTED, Comparison
from bench.bass import bass_agent_of
from bench.learning import play_all, runs
from bench.results.chart import chart
from bench.results.episode_log import EpisodeLog, Outcome
from bench.results.page import measured_part, write_report
from movingout.agents.bass.accuracy import BassAccuracy, bass_accuracy
from movingout.agents.catalogue import UNSEEN_TCR
from movingout.agents.checkpoint.card import Card, Score
from movingout.agents.checkpoint.checkpoint import SHIPPED, Checkpoint, find_checkpoint, rescored
from movingout.agents.curriculum.partners import clone_stage
from movingout.agents.curriculum.recipe import Sizes, recipe
from movingout.agents.curriculum.steps import run_stages
from movingout.agents.data.held_out import held_out_episodes
from movingout.agents.scripted.populations import population
from movingout.maps import map_names
from movingout.maps.errors import MovingOutError
from movingout.world.constants import LIMIT_TICKS
from movingout.world.estimates import estimate


def main(words: Sequence[str] | None = None) -> None:
    """Parse and run the steps; exit with a message if that is impossible."""
    try:
        _run(_parsed(words))
    except MovingOutError as error:
        raise SystemExit(f"train_agents: {error}") from error


def _run(args: argparse.Namespace) -> None:
    sizes = Sizes(**{entry.name: vars(args)[entry.name] for entry in dataclasses.fields(Sizes)})
    stages = [clone_stage(sizes)] if args.clones else recipe(sizes)
    if args.dry_run:
        print("\n".join(shlex.join(("movingout", *step.words)) for stage in stages for step in stage))
        return
    if not args.only_evaluate and not args.finished:
        run_stages(stages, args.workers)
    if args.clones:
        return
    left_out = _left_out(args)
    both, of_a = (
        field._replace(learners={one: label for one, label in field.learners.items() if one not in left_out})
        for field in (OF_BOTH, OF_A)
    )
    played, played_of_a = _played(args, (both, of_a))
    if not played["C"]:
        raise MovingOutError("no agent has played with people of C yet, so there are no tables; leave out --finished")
    unseen = list(dict.fromkeys(played["C"] + played_of_a["C"]))  # the controls occur in both
    cards = _rescored(args, [*both.learners, *of_a.learners], unseen)
    numbers = None if args.no_parts else _parts_of_bass(args)
    command = "python -m bench.train_agents" + " --by-nfd" * (PAPER_BASS in both.learners)
    measured = measured_part((both, played), (of_a, played_of_a), cards, numbers, command)
    write_report(args.report, measured, chart(played["C"], both.learners))


def _left_out(args: argparse.Namespace) -> set[str]:
    """Agents left out of the tables; with --finished, only those excluded or not trained."""
    if args.finished:
        return {*args.without, *_not_trained(args.data)}
    return {*args.without, *(() if args.by_nfd else CHOOSING_BY_NFD)}


def _not_trained(data: Path) -> list[str]:
    """Agents of the tables that have no checkpoint yet; prints them."""
    missing = []
    for agent_id in [*OF_BOTH.learners, *OF_A.learners]:
        try:
            find_checkpoint(agent_id.partition(":")[0], data / "models", SHIPPED)
        except MovingOutError:
            print(f"{agent_id}: not trained yet, left out of the tables", flush=True)
            missing.append(agent_id)
    return missing


def _played(args: argparse.Namespace, fields: Sequence[Comparison]) -> list[dict[str, list[Outcome]]]:
    """Outcomes by population, for each comparison."""
    maps, log = list(map_names()), args.data / "evaluation.jsonl"
    todo = [
        {
            group: runs([*field.learners, SCRIPTED, CONTROL], _people(group), maps, args.runs, args.ticks)
            for group in field.partners
        }
        for field in fields
    ]
    wanted = list(dict.fromkeys(run for groups in todo for made in groups.values() for run in made))
    if args.finished:
        done = EpisodeLog(log).known(wanted)
    else:
        done = {one.run: one for one in play_all(wanted, args.workers, log)}
    return [{group: [done[run] for run in made if run in done] for group, made in groups.items()} for groups in todo]


def _rescored(args: argparse.Namespace, agents: Sequence[str], unseen: Sequence[Outcome]) -> dict[str, Card]:
    """The cards of agents that have played, with their scores beside people never trained with."""
    cards, have_played = {}, {one.run.agent for one in unseen}
    for agent_id in agents:
        if ":" not in agent_id and agent_id in have_played:
            checkpoint, measured = find_checkpoint(agent_id, args.data / "models", SHIPPED), scores(unseen, agent_id)
            cards[agent_id] = rescored(checkpoint, measured).card if _news(checkpoint, measured) else checkpoint.card
    return cards


def _news(checkpoint: Checkpoint, measured: Mapping[str, Score]) -> bool:
    """Whether to write scores to a card: never to shipped ones, nor over scores from more episodes."""
    if checkpoint.folder.parent == SHIPPED:
        return False
    before, now = checkpoint.card.scores.get(UNSEEN_TCR), measured[UNSEEN_TCR]
    if before is not None and before.n > now.n:
        print(f"{checkpoint.card.id}: its card keeps its scores of {before.n} episodes; these are {now.n}", flush=True)
        return False
    return True


def _people(group: str) -> list[str]:
    """Agent ids of the people of the populations named by the letters of `group`, in turn."""
    populations = [population(name) for name in group]
    return [person.agent_id for people in zip(*populations, strict=True) for person in people]


def _parsed(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    positive = at_least(1)
    parser.set_defaults(data=Path("data"))  # where the worker processes look for models
    for entry in dataclasses.fields(Sizes):
        if "least" in entry.metadata:
            kind, text = at_least(entry.metadata["least"]), f"{entry.metadata['help']} (%(default)s)"
            parser.add_argument(f"--{entry.name.replace('_', '-')}", type=kind, default=entry.default, help=text)
    parser.add_argument("--dry-run", action="store_true", help="print the training commands and exit")
    parser.add_argument(
        "--clones",
        action="store_true",
        help="train only the six clones of the family `clone` that do not ship, from the labels of a finished run",
    )
    parser.add_argument(
        "--without", action="append", default=[], metavar="ID", choices=[*OF_BOTH.learners, *OF_A.learners],
        help="leave this agent out of the tables; repeatable",
    )  # fmt: skip
    parser.add_argument(
        "--by-nfd", action="store_true",
        help="also evaluate BASS of A and B choosing by NFD (7 minutes); that of A alone always does",
    )  # fmt: skip
    parser.add_argument("--no-parts", action="store_true", help="leave out the section on the parts of BASS")
    parser.add_argument("--only-evaluate", action="store_true", help="train nothing")
    parser.add_argument(
        "--finished", action="store_true", help="make tables from the episodes played so far; play no more"
    )
    parser.add_argument("--runs", type=positive, default=20, help="evaluation episodes per map and agent")
    parser.add_argument("--ticks", type=positive, default=LIMIT_TICKS)
    parser.add_argument("--workers", type=positive, default=os.cpu_count() or 1)
    parser.add_argument("--report", type=Path, default=Path("docs/twelve-maps.md"))
    args = parser.parse_args(words)
    if not args.clones and not args.report.parent.is_dir():  # fail now rather than after two hours
        parser.error(f"argument --report: there is no folder {args.report.parent}")
    return args


def at_least(least: int) -> Callable[[str], int]:
    """A parser for integer options of at least `least`."""

    def number(text: str) -> int:
        value = int(text)
        if value < least:
            raise argparse.ArgumentTypeError(f"must be at least {least}")
        return value

    number.__name__ = "number"  # shown in argparse's error messages
    return number


def _parts_of_bass(args: argparse.Namespace) -> BassAccuracy:
    """Accuracy of next state, partner prediction and selection on one episode of C per map."""
    trajectories = held_out_episodes(challenge=1, ticks=args.ticks, workers=args.workers)
    return bass_accuracy(bass_agent_of(PAPER_BASS), trajectories, moments=20, seed=0)


def scores(outcomes: Sequence[Outcome], agent: str) -> dict[str, Score]:
    """Scores for a card: TCR and NFD with unseen people, and the TCR of these people with the control."""
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
    found = estimate(values)
    if found is None:
        raise ValueError("an agent that played no episode has no score")
    return Score(mean=round(found.mean, 4), stderr=round(found.stderr or 0.0, 4), n=found.n)


if __name__ == "__main__":
    main()
