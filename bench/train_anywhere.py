"""Train the agents that play anywhere, measure them and print their tables; finished steps are skipped.

    python -m bench.train_anywhere --workers 2

1. a pair of experts plays generated maps of the training seeds; those it solves are listed;
2. an expert plays on them with scripted partners, with occasional slips of its hand;
3. a Diffusion Policy that sees nothing absolute (`relative-v1`) is trained on these episodes;
4. it takes turns with the expert (DAgger) and is trained further; `--rounds` times;
5. Diffusion Policy is trained from scratch on all labels, `--seeds` times;
6. each plays alone with the same partners; a value of BASS is trained on all these episodes, and again with those that
   BASS then plays;
7. with `--response-rounds N`, reinforcement learning makes a best response of the policy, on its leash;
8. these, the expert and an idle partner play on the paper's maps, their symmetries and generated test maps.

Steps 1 to 7 are `agents.curriculum.recipe_anywhere`; `--dry-run` prints their commands. A restarted command resumes
where it stopped; finished evaluation episodes are in data/anywhere/evaluation.jsonl. Another `--data` folder than data
begins anew, as it must with other sizes. Nothing is trained with people of C or on test seeds. Partners are the
families (`agents.partners.families`) unless `--partners` names others.
"""

import argparse
import dataclasses
import os
import shlex
from collections.abc import Sequence
from pathlib import Path

from bench import anywhere
from bench.results.anywhere_tables import CONTROL, Played
from bench.train_agents import at_least, scores
from movingout.agents.checkpoint.checkpoint import MODELS_VARIABLE, find_checkpoint, rescored
from movingout.agents.curriculum.begun import check_begun, note_begun
from movingout.agents.curriculum.recipe_anywhere import (
    BASS_ANY,
    DP_ANY,
    RESPONSE_ANY,
    AnywhereSizes,
    check_partners,
    of_seeds,
    recipe_anywhere,
)
from movingout.agents.curriculum.steps import run_stages
from movingout.maps.errors import MovingOutError
from movingout.world.constants import LIMIT_TICKS


def main(words: Sequence[str] | None = None) -> None:
    """Parse and run the steps; exit with a message if that is impossible."""
    args = _parsed(words)
    names = [entry.name for entry in dataclasses.fields(AnywhereSizes)]
    sizes = AnywhereSizes(**{name: vars(args)[name] for name in names})
    os.environ[MODELS_VARIABLE] = str(sizes.data.resolve() / "models")  # for the steps, and for those who play
    try:
        check_partners(sizes.partners)
        if not args.only_evaluate:
            check_begun(sizes)
        stages = recipe_anywhere(sizes)
        if args.dry_run:
            print("\n".join(shlex.join(("movingout", *step.words)) for stage in stages for step in stage))
            return
        if not args.only_evaluate:
            note_begun(sizes)
            run_stages(stages, args.workers)
        _measure(args, sizes)
    except MovingOutError as error:
        raise SystemExit(f"train_anywhere: {error}") from error


def _measure(args: argparse.Namespace, sizes: AnywhereSizes) -> None:
    """Play, print the tables, and write to the cards how the agents did."""
    response = [RESPONSE_ANY] * bool(sizes.response_rounds)
    learned = [BASS_ANY, DP_ANY, *response]
    learned += [
        name for name in (*of_seeds(DP_ANY, sizes.seeds), *of_seeds(BASS_ANY, sizes.seeds)) if name not in learned
    ]
    for name in learned:
        find_checkpoint(name, sizes.data / "models")  # before hours of play
    where = ["--ray", args.ray] if args.ray else ["--workers", str(args.workers)]
    played = anywhere.main([
        "--agents", *learned, "dp@all", "bass@all", "scripted", CONTROL,
        "--partners", *args.measured_with, "--runs", str(args.runs), "--ticks", str(args.ticks),
        *where, "--log", str(sizes.data / "anywhere" / "evaluation.jsonl"),
    ])  # fmt: skip
    for agent_id in learned:
        _write_scores(sizes.data / "models", agent_id, played[args.measured_with[0]])


def _write_scores(models: Path, agent_id: str, played: Played) -> None:
    """Write to a card how its agent did, over all groups of maps."""
    outcomes = [one for name in (agent_id, CONTROL) for cell in played[name].values() for one in cell]
    rescored(find_checkpoint(agent_id, models), scores(outcomes, agent_id))


def _parsed(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path("data"), help="folder of everything made (%(default)s)")
    for entry in dataclasses.fields(AnywhereSizes):
        if "least" in entry.metadata:
            kind, text = at_least(entry.metadata["least"]), f"{entry.metadata['help']} (%(default)s)"
            parser.add_argument(f"--{entry.name.replace('_', '-')}", type=kind, default=entry.default, help=text)
    parser.add_argument(
        "--partners", default="families", help="whom `demos label --population` lets play (%(default)s)"
    )
    parser.add_argument("--paper-maps", action="store_true", help="train on the paper's maps too, in all symmetries")
    parser.add_argument("--measured-with", nargs="+", default=["C"], help="groups of partners of `bench.anywhere`")
    parser.add_argument("--runs", type=at_least(1), default=60, help="evaluation episodes per cell (%(default)s)")
    parser.add_argument("--dry-run", action="store_true", help="print the training commands and exit")
    parser.add_argument("--only-evaluate", action="store_true", help="train nothing")
    parser.add_argument("--ticks", type=at_least(1), default=LIMIT_TICKS)
    parser.add_argument("--workers", type=at_least(1), default=os.cpu_count() or 1)
    parser.add_argument("--ray", default="", metavar="auto|ADDRESS", help="episodes are played on a Ray cluster")
    return parser.parse_args(words)


if __name__ == "__main__":
    main()
