"""`movingout study` report, export, forget and purge: what to do with the data of a study that was run."""

import argparse
import importlib
import json
import sys
from contextlib import closing, nullcontext, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from movingout.maps.commands.parser import add_out
from movingout.maps.extras import needs_extra
from movingout.maps.files.terminal import printable_lines
from movingout.maps.suggestion import counted
from movingout.recordings.commands.arguments import share
from movingout.recordings.report.words import LANGUAGES
from movingout.study.commands.place import add_place, folder_of, folder_to_forget
from movingout.study.data.erasure import due_now, erase, purge, unknown_to
from movingout.study.data.export import FORMATS, Options, export_study
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.allocation import assign, letters
from movingout.study.design.balance import seat_imbalance
from movingout.study.design.definition import ALLOCATION, Study
from movingout.study.design.study_file import retention_of
from movingout.study.errors import StudyError
from movingout.study.store import Store
from movingout.study.store.frozen_study import frozen_study
from movingout.study.store.tables import participants


def configure(commands: Any) -> None:
    """Add the sub-commands to those of `movingout study`."""
    report = commands.add_parser(
        "report",
        help="results: tables, figures and tests on one offline page, and CSV",
        example="movingout study report study.yaml -o report",
    )
    add_place(report)
    add_out(report, "DIR", "default: ID-report, or ID-simulated-report; never overwritten")
    report.add_argument("--language", choices=LANGUAGES, help="of the page (default: the study's first language)")
    report.add_argument("--blinded", action="store_true", help="partners by letter, as participants saw them")
    report.add_argument(
        "--annotations",
        nargs="+",
        type=Path,
        default=(),
        metavar="FILE",
        help="verdicts on failure cases from elsewhere, besides those of the page /annotate here",
    )
    report.set_defaults(perform=_report)

    export = commands.add_parser(
        "export",
        help="tables, codebook, recordings and training set, in a new folder",
        example="movingout study export study.yaml -o export",
    )
    add_place(export)
    add_out(export, "DIR", "default: ID-export, or ID-simulated-export; never overwritten")
    export.add_argument("--formats", nargs="+", choices=FORMATS, default=FORMATS, help="of the tables; default: all")
    export.add_argument(
        "--test-share", type=share, default=0.2, help="of the training set, by participants (%(default)s)"
    )
    export.add_argument("--no-training", action="store_true", help="tables only")
    export.add_argument("--released", action="store_true", help="only who ticked the box `release`: for publishing")
    export.set_defaults(perform=_export)

    forgetting = commands.add_parser(
        "forget",
        help="delete a participant's answers, identity and recordings",
        example="movingout study forget study.yaml P7KXM2Q",
    )
    add_place(forgetting)
    forgetting.add_argument(
        "pid", metavar="PID", help="pseudonym, such as P7KXM2Q, completion code of theirs alone, or ID on a platform"
    )
    forgetting.set_defaults(perform=_forget)

    purging = commands.add_parser(
        "purge",
        help="delete what is past the study's retention period; without --apply only list it",
        example="movingout study purge study.yaml --apply",
    )
    add_place(purging)
    purging.add_argument("--apply", action="store_true", help="really remove")
    purging.add_argument(
        "--unknown",
        action="store_true",
        help="also identities of people whom the database does not know, as where an older one was put back",
    )
    purging.set_defaults(perform=_purge)


def as_frozen(folder: StudyFolder, store: Store, file: Path) -> StudyFolder:
    """With the study that the data were recorded with; says so where the file has changed since."""
    begun = folder.as_frozen(store, file.parent)
    if begun.study.allocated_by(folder.study.allocation) != folder.study:
        print(f"warning: {file} has changed since the study began; the file from then is used", file=sys.stderr)
    return begun


def seats_told(study: Study, *, blinded: bool = False) -> list[str]:
    """Blocks of its planned orders in which seats go together with partners or maps, as they may by earlier rules."""
    orders = [assign(study, slot) for slot in range(study.units)]
    return list(seat_imbalance(study, orders, letters(study) if blinded else None))


def earlier_seats_told(folder: StudyFolder) -> list[str]:
    """The same, of a study that has begun by an earlier rule; `check` says it of the newest."""
    with suppress(StudyError), closing(folder.open_existing()) as store:
        rule = frozen_study(store).allocation
        if rule != ALLOCATION and store.rows(participants):
            return seats_told(folder.study.allocated_by(rule))
    return []


def older_database_told(folder: StudyFolder) -> list[str]:
    """A warning where people are known whom the main database does not know: served like this, they begin once more."""
    with closing(folder.open()) as store, folder.existing_identities() as identities:
        unknown = unknown_to(store, identities) if identities else []
    if not unknown:
        return []
    return [
        f"{len(unknown)} of the identities are of people who opened the study, but its database does not know them: it "
        "is older, as where a copy of before was put back, or a server of an earlier version was killed. They would "
        "begin once more, and may be paid twice. Stop the server and bring the newest database back, or a whole backup "
        "into a new folder (movingout study restore)"
    ]


def _report(args: argparse.Namespace) -> int:
    with needs_extra("analysis", "a report"):
        analysis = importlib.import_module("movingout.study.commands.report")  # statistics take seconds to import
    code: int = analysis.report(folder_of(args), args)
    return code


def _export(args: argparse.Namespace) -> int:
    folder = folder_of(args)
    options = Options(tuple(args.formats), args.test_share, not args.no_training, args.released)
    with closing(folder.open_existing()) as store:
        folder = as_frozen(folder, store, args.file)
        target = args.out or folder.output("export", frozen_study(store).simulated)
        done = export_study(folder, store, target, options)
    document = {"export": str(target), "rows": done.rows, "recordings": done.recordings}
    document |= {"repeated": done.repeated}
    warnings = [*done.warnings, *seats_told(folder.study)]
    again = f" ({done.repeated} of them further attempts)" if done.repeated else ""
    _say(args, {**document, "missing": done.missing, "warnings": warnings}, [
        f"wrote {target}: {counted(done.rows['participants'], 'participant')}, "
        f"{counted(done.rows['rounds'], 'round')}{again}, {counted(done.rows['answers'], 'answer')}, "
        f"{counted(done.recordings, 'recording')}",
        *(f"missing: recording {name} of a round is not in {folder.recordings}" for name in done.missing),
        *(f"warning: {sentence}" for sentence in warnings),
    ])  # fmt: skip
    return 0


def _forget(args: argparse.Namespace) -> int:
    folder = folder_to_forget(args)
    with closing(folder.open_existing()) as store, folder.exclusive():
        with suppress(StudyError):  # today's file where that of then cannot be read; folders have its name
            begun = as_frozen(folder, store, args.file).study
            folder = replace(folder, study=begun.model_copy(update={"id": folder.study.id}))
        done = erase(folder, store, args.pid)
    document = {"pid": done.pid, "rows": done.rows, "recordings": done.recordings, "identity": done.identity}
    sentence = f"forgot {done.pid}: {done.rows} rows, {done.recordings} recordings, identity: "
    _say(args, document, [
        sentence + ("removed" if done.identity else "none was kept"),
        "earlier exports still contain the participant; export again",
    ])  # fmt: skip
    return 0


def _purge(args: argparse.Namespace) -> int:
    folder = folder_of(args, deletes=True)
    with closing(folder.open_existing()) as store, folder.exclusive() if args.apply else nullcontext():
        folder = _keeping_promises(folder, store, args.file)
        found = (purge if args.apply else due_now)(folder, store, unknown_too=args.unknown)
    document = {"applied": args.apply, "identities": list(found.identities), "participants": list(found.trials)}
    document["without_consent"] = list(found.undecided)
    document["may_take_part_again"] = found.may_return
    verb = "removed" if args.apply else "due"
    _say(args, document, [
        f"{verb}: {len(found.identities)} identities, {len(found.trials)} participants with everything",
        *([f"{verb}: {counted(len(found.undecided), 'visitor')} who never consented"] if found.undecided else []),
        *_who_may_return(found.may_return, args.apply),
        *([] if args.apply else ["nothing was removed; add --apply to remove it"]),
    ])  # fmt: skip
    return 0


def _who_may_return(number: int, applied: bool) -> list[str]:
    """A warning while the study still recruits: nothing but their identity tells that somebody was there."""
    if not number:
        return []
    people = f"{counted(number, 'participant')} whose identity {'was' if applied else 'would be'} deleted"
    what = "can take part again, as somebody new, and be paid again"
    return [f"warning: the study still recruits: while it is served, {people} {what}; serve it no more, or purge later"]


def _keeping_promises(folder: StudyFolder, store: Store, file: Path) -> StudyFolder:
    """With no period longer than what participants agreed to, and none longer than the file says today.

    Raises StudyError.
    """
    today = folder.study.retention
    kept = today.shortest(retention_of(frozen_study(store).file_text))
    if kept != today:
        print(f"warning: {file} keeps data longer than participants agreed to; their periods are used", file=sys.stderr)
    return replace(folder, study=folder.study.model_copy(update={"retention": kept}))


def _say(args: argparse.Namespace, document: dict[str, object], sentences: list[str]) -> None:
    """Sentences may quote databases and files of others, such as a backup that was restored."""
    print(json.dumps(document, indent=2) if args.json else printable_lines("\n".join(sentences)))
