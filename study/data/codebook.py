"""What every table and column of an export means, and every question with its scale."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from movingout.study.design.definition import Study
from movingout.study.design.translations import questionnaires_asked
from movingout.study.questionnaire import USUAL_ENDS, QuestionnaireItem
from movingout.study.store.store import Store
from movingout.study.store.tables import exported

_TABLES = {
    "study": "What the study was run with; one row.",
    "units": "Participants or pairs with their slot of the allocation.",
    "participants": "Who took part, by pseudonym.",
    "consents": "Consents; the text itself is in study.yaml.",
    "rounds": "Rounds, one per recording. `partner` is the id in study.yaml.",
    "players": "How a round went for each participant.",
    "answers": "Every click. Free text is what people typed.",
    "notes": "Notes of the experimenter.",
    "counts": "Numbers of those of whom nothing else is kept.",
    "audit": "Who did what, and when; participants are hashes.",
    "tombstones": "Withdrawals: how much was removed.",
    "allocation": "What each unit was to play, in its order.",
    "recordings": "The recording of each round that is finished.",
}


class DerivedColumn(NamedTuple):
    """A column that only exports have."""

    kind: type
    meaning: str


_MAP_NAME = (
    "its name in recordings and `training/`, of a map file the name inside; where several files have one name, "
    "`training/` adds .1, .2, and only `map` tells them apart here"
)
DERIVED: Mapping[str, Mapping[str, DerivedColumn]] = {
    "answers": {"counts": DerivedColumn(bool, "whether it is the newest answer to its item, the one that counts")},
    "rounds": {"map_name": DerivedColumn(str, _MAP_NAME)},
    "allocation": {
        "unit": DerivedColumn(int, "number of the unit"),
        "slot": DerivedColumn(int, "slot of the allocation, from 0"),
        "position": DerivedColumn(
            int, "which planned round of the unit this is, from 1; rounds.position counts repeated ones, too"
        ),
        "block": DerivedColumn(str, "block of the study"),
        "partner": DerivedColumn(str, "id of the partner; in pairs empty"),
        "map": DerivedColumn(str, "as study.yaml names it"),
        "seat": DerivedColumn(int, "of the first of the unit: 0 blue, 1 red"),
        "variant_seed": DerivedColumn(int, "of a randomised map, empty for the map as designed"),
        "step": DerivedColumn(str, "key of the step: with `unit` it leads to the attempts in `rounds`"),
        "map_name": DerivedColumn(str, _MAP_NAME),
    },
    "recordings": {
        "episode": DerivedColumn(str, "id of the recording"),
        "round": DerivedColumn(int, "round"),
        "file": DerivedColumn(str, "name of the file in the recordings folder"),
        "sha256": DerivedColumn(str, "of the file"),
    },
}


def codebook(study: Study, store: Store) -> str:
    """The codebook as Markdown."""
    return "\n".join(_lines(study, store)) + "\n"


def _lines(study: Study, store: Store) -> Iterator[str]:
    yield f"# Codebook of {study.title.text()}"
    yield ""
    yield "Times are milliseconds since the epoch (UTC). Empty: unknown, or it does not apply."
    kept = store.tables()
    for name in sorted({*kept, *DERIVED}):
        yield from ("", f"## {name}", "", _TABLES[name], "", "| column | meaning |", "|---|---|")
        columns = exported(kept[name]) if name in kept else []
        yield from (f"| {column.name} | {column.doc or 'number of the row'} |" for column in columns)
        yield from (f"| {column} | {made.meaning} |" for column, made in DERIVED.get(name, {}).items())
    for name in questionnaires_asked(study):
        yield from ("", f"## Questionnaire {name}", "", "| item | scale | question |", "|---|---|---|")
        for item in study.questionnaire(name).items:
            yield f"| {item.id} | {_cell(_scale(item))} | {_cell(item.text)} |"


def _cell(text: str) -> str:
    """Text of a study file so that it stays within its cell of a Markdown table."""
    return text.strip().replace("|", "\\|").replace("\n", "<br>")


def _scale(item: QuestionnaireItem) -> str:
    expected = f", attention: {item.expected}" if item.expected is not None else ""
    if item.kind == "choice":
        options = (f"{value}: {option}" for value, option in enumerate(item.options))
        return "; ".join(["-1: no answer", *options]) + expected
    if item.kind == "text":
        return "free text"
    low, high = item.ends if any(item.ends) else USUAL_ENDS[item.kind]
    return f"{item.allowed()[0]} to {item.allowed()[-1]} ({low} to {high}){expected}, -1 no answer"
