"""The measured part of docs/twelve-maps.md: tables made from outcomes, beside the paper's.

Text around it is written by hand; everything between the two marks is replaced.
"""

import datetime
import os
import platform
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

from bench._roster import PAPER_BASS, PAPER_COLUMNS, Comparison
from bench.learning import table
from bench.results.bass_tables import BASS as ROLE
from bench.results.bass_tables import tables
from bench.results.episode_log import Outcome
from bench.results.paired_differences import LEGEND, against_aim, leads
from movingout.agents.bass.accuracy import BassAccuracy
from movingout.agents.checkpoint.card import Card
from movingout.maps import map_names
from movingout.matches.experiment.paper_reference import paper_figures
from movingout.world.estimates import estimate, estimate_text

BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"


def write_report(path: Path, measured: str, picture: str) -> None:
    """Put `measured` between the marks of the page; a page without marks gets them at its end.

    The `picture`, an SVG kept beside the page, goes above it.
    """
    beside = path.with_suffix(".svg")
    beside.write_text(picture, encoding="utf-8")
    measured = f"![TCR of each agent with people of C]({beside.name})\n\n{measured}"
    page = path.read_text(encoding="utf-8") if path.exists() else "# Results\n\n"
    before, begin, rest = page.partition(BEGIN)
    after = rest.partition(END)[2] if begin else "\n"
    path.write_text(f"{before}{BEGIN}\n{measured}\n{END}{after}", encoding="utf-8")


Played = Mapping[str, Sequence[Outcome]]
"""Outcomes by population of the partners."""


def measured_part(
    both: tuple[Comparison, Played],
    of_a: tuple[Comparison, Played],
    cards: Mapping[str, Card],
    numbers: BassAccuracy | None,
    command: str,
) -> str:
    """Everything between the marks: results of agents trained with A and B, and of those trained with A alone.

    `cards` are those of the learned agents; `command` makes these tables.
    """
    today = datetime.datetime.now(datetime.UTC).date().isoformat()
    field, played = both
    unseen = played["C"]
    parts = [
        f"Measured on {today}, {platform.machine()}, {os.cpu_count()} cores, by `{command}`.",
        f"Partners are scripted people; {unseen[0].run.ticks} ticks; all maps count the same; errors are standard "
        "errors over episodes. `idle` is the control: what these people achieve alone. `scripted` is the expert; the "
        "others learned from a variant of it that does not stop to think.",
        *_tables(field, played, "##"),
        "## Compared with the paper (Challenge 1)",
        _beside_paper(unseen, field.learners),
        "The paper's partners were policies and people; ours are scripted people of C. So the columns show the order "
        "of the methods, not which system is better. The paper's comparison of methods (`tab:full_results_in_t1`) and "
        "its main table (`tab:task_1_results`) are two experiments. Its DP/BASS chooses among four independent pairs; "
        "ours by NFD chooses among 4 × 4, the best of the paper's three sampling schemes. AC is by the paper's "
        "formula, which its numbers do not look like ([metrics.md](metrics.md)).",
        "## Compared with the target and the base policy",
        against_aim(unseen),
        LEGEND,
        leads(field, played),
        *_apart(*of_a),
        *(["## The parts of BASS by NFD", _parts(numbers)] if numbers else []),
        "## What was trained",
        _trained(cards),
    ]
    return "\n\n".join(parts)


def _tables(field: Comparison, played: Played, level: str) -> Iterator[str]:
    for group, partners in field.partners.items():
        if not played[group]:
            continue  # no agent has played with them yet
        yield f"{level} With {partners}"
        yield table(list(played[group]), _agents(played[group]), list(map_names()))


def _agents(outcomes: Sequence[Outcome]) -> list[str]:
    return list(dict.fromkeys(one.run.agent for one in outcomes))


def _apart(field: Comparison, played: Played) -> Iterator[str]:
    """The section on agents trained with one population alone; empty if none has played."""
    if not any(one.run.agent in field.learners for outcomes in played.values() for one in outcomes):
        return
    yield "## Trained with people of A alone"
    yield "TCR and NFD by how well the agent knows its partners; a policy that had memorised people would drop."
    yield _generalisation(field, played)
    yield from _tables(field, played, "###")
    yield "### Compared with the base policy"
    yield leads(field, played)


def _generalisation(field: Comparison, played: Played) -> str:
    """A table of agents by kind of partner."""
    heads = " | ".join(f"{partners}: TCR | NFD | n" for partners in field.partners.values())
    lines = [f"| agent | as in the paper | {heads} |", "|---" * (2 + 3 * len(field.partners)) + "|"]
    for agent in dict.fromkeys(agent for outcomes in played.values() for agent in _agents(outcomes)):
        cells = []
        for group in field.partners:
            mine = [one for one in played[group] if one.run.agent == agent]
            cells += [estimate_text(estimate([getattr(one, name) for one in mine])) for name in ("tcr", "nfd")]
            cells.append(str(len(mine)))
        lines.append(f"| {agent} | {field.learners.get(agent, '')} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _beside_paper(outcomes: Sequence[Outcome], labels: Mapping[str, str]) -> str:
    of = "TCR | NFD | AC"
    head = f"| agent | as in the paper | ours: {of} | " + " | ".join(f"{name}: {of}" for name in PAPER_COLUMNS) + " |"
    lines = [head, "|---" * (5 + 3 * len(PAPER_COLUMNS)) + "|"]
    for agent in _agents(outcomes):
        mine = [one for one in outcomes if one.run.agent == agent]
        ours = [estimate([v for one in mine if (v := getattr(one, name)) is not None]) for name in ("tcr", "nfd", "ac")]
        cells = [estimate_text(found) for found in ours]
        for rows in PAPER_COLUMNS.values():
            figures = paper_figures(rows[agent][0], 1, rows[agent][1]) if agent in rows else {}
            cells += [f"{figures[name].mean:.3f}" if name in figures else "" for name in ("tcr", "nfd", "ac")]
        lines.append(f"| {agent} | {labels.get(agent, '')} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _parts(numbers: BassAccuracy) -> str:
    return tables({PAPER_BASS: asdict(numbers)}, {PAPER_BASS: ROLE}, challenge=1)


def _trained(cards: Mapping[str, Card]) -> str:
    lines = ["| agent | episodes | windows | updates | width | size |", "|---" * 6 + "|"]
    for agent, card in cards.items():
        size = sum(entry.bytes for entry in card.files) / 1e6
        of = card.training
        lines.append(
            f"| {agent} | {of.episodes} | {of.windows} | {of.updates} | {card.network.width} | {size:.1f} MB |"
        )
    return "\n".join(lines)
