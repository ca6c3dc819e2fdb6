"""`movingout train KIND …`: from recordings to an agent that can take a seat."""

import argparse
import importlib.util
import json
import sys
from pathlib import Path
from typing import Any

from movingout.agents.catalogue import load_agent
from movingout.agents.checkpoint.checkpoint import MODELS_VARIABLE, check_labels, check_room, model_roots, ships
from movingout.agents.errors import CheckpointError, DataError
from movingout.agents.kinds.kind import AgentKind, Trained
from movingout.agents.kinds.registry import KINDS
from movingout.agents.map_limits import check_own_maps_seen
from movingout.agents.training import run_folder
from movingout.agents.training.options import add_fields, overridden
from movingout.agents.training.run import TrainingRun
from movingout.maps.extras import MissingExtraError
from movingout.maps.suggestion import counted
from movingout.recordings.groups import of_group
from movingout.world.exactness import inexact_engine


def configure(parser: argparse.ArgumentParser) -> None:
    """One sub-command per kind, its options made from the kind's configuration."""
    kinds = parser.add_subparsers(dest="kind", required=True, metavar="KIND")
    for kind in KINDS.values():
        sub = kinds.add_parser(
            kind.name,
            help=kind.summary,
            description=f"Train {kind.summary}.",
            example=f"movingout train {kind.name} {kind.example} --id {kind.name}@mine",
        )
        _recordings(sub, kind)
        _common(sub, kind, default_id=f"{kind.name}@mine")
        numbers = "the paper's numbers or ours" if "paper" in kind.presets else "our numbers; the paper has none"
        sub.add_argument("--preset", choices=[*kind.presets], default="fast", help=f"{numbers} (default fast)")
        kind.add_options(sub)
        add_fields(sub, type(kind.presets["fast"]))


def _recordings(parser: argparse.ArgumentParser, kind: AgentKind[Any]) -> None:
    """What is learned from. Kinds that learn from their own play read these options only to refuse them."""

    def shown(text: str) -> str:
        return text if kind.from_recordings else argparse.SUPPRESS

    parser.add_argument(
        "recordings",
        nargs="*",
        type=Path,
        help=shown("recordings (*.mcap), files with an expert's labels (*.corrections.npz), or folders of them"),
    )
    parser.add_argument(
        "--manifest",
        type=Path,
        metavar="FILE.csv",
        help=shown("a list made by `recordings split`; learn from one --group of it"),
    )
    parser.add_argument("--group", type=int, metavar="N", help=shown("of --manifest (default 1)"))
    parser.add_argument(
        "--without",
        action="append",
        default=[],
        metavar="WHO",
        help=shown(
            "leave out episodes with these partners, as family:greedy, people:B, @FILE or an agent id; may be repeated"
        ),
    )


def _common(parser: argparse.ArgumentParser, kind: AgentKind[Any], default_id: str) -> None:
    parser.add_argument("--id", default=default_id, help=f"id of the new agent (default {default_id})")
    parser.add_argument("--name", default="", help="name shown in the lobby (default: made from the kind)")
    whose = "who acts in the recordings" if kind.from_recordings else "with whom it learned"
    parser.add_argument("--population", default="", help=f"{whose}, in a few words, for the card")
    parser.add_argument(
        "--go-on",
        action="store_true",
        help="continue this id's training although the data or the options have changed",
    )
    parser.add_argument(
        "--instead-of-shipped",
        action="store_true",
        help="take an id that ships: whoever uses this data folder then gets the new agent by it",
    )
    parser.add_argument(
        "--data",
        type=Path,
        default=Path("data"),
        help="data folder (default ./data); of another, agents play where MOVINGOUT_MODELS=DATA/models is set",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON document about the result")


def run(args: argparse.Namespace) -> int:
    """Train, export, write DATA/models/<id>.

    Raises DataError, CheckpointError or MissingExtraError before anything is trained.
    """
    check_labels(args.id, args.name, args.population)
    kind = KINDS[args.kind]
    _check_word(args.id, kind)
    if not kind.from_recordings:
        _refuse_recordings(args)
    if args.manifest is not None:
        group = 1 if args.group is None else args.group
        args.recordings = [*args.recordings, *of_group(args.manifest, group)]
    elif args.group is not None:
        raise DataError(f"--group {args.group} is of the list that --manifest names; name it, too")
    config = overridden(kind.presets[args.preset], args)
    wanted = TrainingRun(
        kind=kind.name,
        config=config,
        options=args,
        kept_options=kind.option_names,
        tell=_tell,
        load_agent=load_agent,
        check_own_maps_seen=check_own_maps_seen,
    )
    check_room(wanted.model_folder, args.id)
    _check_shipped(wanted)
    _require_torch()
    if caution := inexact_engine():
        _tell(f"movingout: {caution}")
    try:
        with wanted.until_its_end:
            trained = kind.train(wanted)
            run_folder.finish(wanted.folder, trained.checkpoint)
    except KeyboardInterrupt:
        goes_on = "goes on from what was saved last" if run_folder.has_learned(wanted.folder) else "begins again"
        _tell(f"movingout: stopped; the same command {goes_on}")
        return 130
    _show(args, wanted.folder, trained)
    return 0


def _show(args: argparse.Namespace, run: Path, trained: Trained) -> None:
    checkpoint, training = trained.checkpoint, trained.training
    if args.json:
        print(json.dumps({"id": args.id, "folder": str(checkpoint.folder), **training.model_dump()}))
        return
    learned = counted(training.episodes, "episode")
    print(f"{args.id}: trained on {learned}, in {checkpoint.folder}; curves: tensorboard --logdir {run}")
    models = checkpoint.folder.parent
    if models.resolve() not in [root.resolve() for root in model_roots()]:
        print(
            f"to play with it, set {MODELS_VARIABLE}={models} for `play`, `match` and `agents`, or copy "
            f"{checkpoint.folder} to data/models"
        )


def _refuse_recordings(args: argparse.Namespace) -> None:
    """Raises DataError where recordings are named for a kind that learns from its own play."""
    given = {
        "the recordings": args.recordings,
        "--manifest": args.manifest,
        "--group": args.group,
        "--without": args.without,
    }
    named = [name for name, value in given.items() if value not in (None, [])]
    if named:
        raise DataError(f"{args.kind} learns from its own play, on maps that --map names; leave out {named[0]}")


def _check_word(agent_id: str, kind: AgentKind[Any]) -> None:
    """Raises CheckpointError for an id that is named after another kind: tables and recordings show the id alone."""
    word, _, own = agent_id.partition("@")
    if word in KINDS and word not in (kind.name, kind.saved_as):
        raise CheckpointError(
            f"{agent_id} would be an agent of kind {kind.name} with the name of another; take --id {kind.name}@{own}"
        )


def _check_shipped(wanted: TrainingRun[Any]) -> None:
    """Raises CheckpointError for the id of an agent that ships, unless that is meant or was begun here before.

    Studies, matches and the lobby would play with the new one.
    """
    begun = wanted.folder.exists() or wanted.model_folder.exists()
    if not (wanted.options.instead_of_shipped or begun) and ships(wanted.agent_id):
        raise CheckpointError(
            f"{wanted.agent_id} ships with the package, and whoever uses this data folder would get the new agent in "
            f"its place; take --id {wanted.kind}@mine, or say --instead-of-shipped"
        )


def _tell(sentence: str) -> None:
    print(sentence, file=sys.stderr)


def _require_torch() -> None:
    if importlib.util.find_spec("torch") is None:
        raise MissingExtraError("train", "training")
