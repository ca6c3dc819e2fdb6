"""The measured part of docs/results.md: tables made from outcomes, beside the paper's.

The page has words around it that people write; what is between the two marks is replaced.
"""

import datetime
import os
import platform
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

from agents.checkpoint import Card
from bench._bass_report import PAPER
from bench._roster import BASS, PAPER_PEOPLE, PAPER_SEEN, PAPER_UNSEEN, Field
from bench.bass import Numbers
from bench.learning import Outcome, mean_error, shown, table
from maps import map_names

BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"
TARGET_TCR = 0.65


def write_report(path: Path, measured: str) -> None:
    """Put `measured` between the marks of the page; a page without them gets them at its end."""
    page = path.read_text(encoding="utf-8") if path.exists() else "# Results\n\n"
    before, begin, rest = page.partition(BEGIN)
    after = rest.partition(END)[2] if begin else "\n"
    path.write_text(f"{before}{BEGIN}\n{measured}\n{END}{after}", encoding="utf-8")


Played = Mapping[str, Sequence[Outcome]]
"""Outcomes by the partners' populations."""


def measured_part(
    both: tuple[Field, Played], of_a: tuple[Field, Played], cards: Mapping[str, Card], numbers: Numbers | None
) -> str:
    """Everything between the marks: what those trained with A and B reached, and those trained with A alone.

    `cards` are the learned agents'.
    """
    today = datetime.datetime.now(datetime.UTC).date().isoformat()
    field, played = both
    unseen = played["C"]
    parts = [
        f"Measured on {today}, {platform.machine()}, {os.cpu_count()} cores, by `python -m bench.train_agents`.",
        f"Partners are scripted people; {unseen[0].run.ticks} ticks, all maps alike; errors are standard errors over "
        "episodes. `idle` is the control: what these people reach alone; `scripted` is the expert that the others "
        "learned from.",
        *_tables(field, played, "##"),
        "## Beside the paper (Challenge 1)",
        _beside_paper(unseen, field.learners),
        "Their partners were policies and people, ours are scripted people of C: the columns show the order of "
        "methods, not who is better.",
        "## Against the aim, and against the base policy",
        "\n".join(f"- {line}" for line in [against_aim(unseen), *leads(unseen, field.compared)]),
        *_apart(*of_a),
        *(["## The parts of BASS by NFD", _parts(numbers)] if numbers else []),
        "## What was trained",
        _trained(cards),
    ]
    return "\n\n".join(parts)


def _tables(field: Field, played: Played, level: str) -> Iterator[str]:
    for group, partners in field.partners.items():
        if not played[group]:
            continue  # nobody has played with them yet
        yield f"{level} With {partners}"
        yield table(list(played[group]), _agents(played[group]), list(map_names()))


def _agents(outcomes: Sequence[Outcome]) -> list[str]:
    return list(dict.fromkeys(one.run.agent for one in outcomes))


def _apart(field: Field, played: Played) -> Iterator[str]:
    """The section on agents trained with one population alone; nothing where none has played."""
    if not any(one.run.agent in field.learners for outcomes in played.values() for one in outcomes):
        return
    yield "## Trained with people of A alone"
    yield "TCR and NFD by what the partners are to the agent; a policy that learned people by heart would fall off."
    yield _generalisation(field, played)
    yield from _tables(field, played, "###")
    yield "\n".join(
        f"- With {partners}: {line}"
        for group, partners in field.partners.items()
        for line in leads(played[group], field.compared)
    )


def _generalisation(field: Field, played: Played) -> str:
    """Agents by kinds of partners."""
    heads = " | ".join(f"{partners}: TCR | NFD | n" for partners in field.partners.values())
    lines = [f"| agent | as in the paper | {heads} |", "|---" * (2 + 3 * len(field.partners)) + "|"]
    for agent in dict.fromkeys(agent for outcomes in played.values() for agent in _agents(outcomes)):
        cells = []
        for group in field.partners:
            mine = [one for one in played[group] if one.run.agent == agent]
            cells += [shown(*mean_error([getattr(one, name) for one in mine])) for name in ("tcr", "nfd")]
            cells.append(str(len(mine)))
        lines.append(f"| {agent} | {field.learners.get(agent, '')} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def against_aim(outcomes: Sequence[Outcome]) -> str:
    """What was aimed at, and by how much it was reached or missed."""
    tcr, error = mean_error([one.tcr for one in outcomes if one.run.agent == BASS])
    reached = "reached" if tcr >= TARGET_TCR else f"missed by {TARGET_TCR - tcr:.3f}"
    return f"`{BASS}` TCR {tcr:.3f} ± {error:.3f}; aimed at {TARGET_TCR}: {reached}."


def leads(outcomes: Sequence[Outcome], compared: Sequence[tuple[str, str]]) -> list[str]:
    """Who is ahead of whom, of those who played."""
    agents = _agents(outcomes)
    return [
        _comparison(outcomes, one, other, name)
        for one, other in compared
        if one in agents and other in agents
        for name in ("tcr", "nfd")
    ]


def _comparison(outcomes: Sequence[Outcome], one: str, other: str, metric: str) -> str:
    """One sentence; the difference is over the episodes that both played, `apart` of the means of these."""
    mean, error = mean_error(gains(outcomes, one, other, metric))
    pairs = [mean_error(values) for values in shared(outcomes, one, other, metric)]
    apart = abs(pairs[0][0] - pairs[1][0]) > pairs[0][1] + pairs[1][1]
    overlap = "the means are farther apart than their standard errors" if apart else "within the standard errors"
    return (
        f"{metric.upper()} of `{one}` minus `{other}`, the same partner, map, seat and seed: {mean:+.3f} ± {error:.3f} "
        f"(n = {len(gains(outcomes, one, other, metric))}; {overlap})."
    )


def gains(outcomes: Sequence[Outcome], one: str, other: str, metric: str) -> list[float]:
    """Differences of a metric between two agents over the episodes that both played."""
    mine, theirs = shared(outcomes, one, other, metric)
    return [a - b for a, b in zip(mine, theirs, strict=True)]


def shared(outcomes: Sequence[Outcome], one: str, other: str, metric: str) -> tuple[list[float], list[float]]:
    """The metric of two agents in the episodes that both played, in the same order."""

    def of(agent: str) -> dict[tuple[object, ...], float]:
        return {
            (o.run.partner, o.run.map, o.run.seat, o.run.seed): getattr(o, metric)
            for o in outcomes
            if o.run.agent == agent
        }

    mine, theirs = of(one), of(other)
    both = [key for key in mine if key in theirs]
    return [mine[key] for key in both], [theirs[key] for key in both]


def _beside_paper(outcomes: Sequence[Outcome], labels: Mapping[str, str]) -> str:
    of = "TCR | NFD | AC"
    papers = {"seen AI": PAPER_SEEN, "unseen AI": PAPER_UNSEEN, "people": PAPER_PEOPLE}
    head = f"| agent | as in the paper | ours: {of} | " + " | ".join(f"paper, {with_}: {of}" for with_ in papers) + " |"
    lines = [head, "|---" * (5 + 3 * len(papers)) + "|"]
    for agent in _agents(outcomes):
        mine = [one for one in outcomes if one.run.agent == agent]
        ours = [
            mean_error([v for one in mine if (v := getattr(one, name)) is not None]) for name in ("tcr", "nfd", "ac")
        ]
        cells = [shown(*pair) for pair in ours]
        for paper in papers.values():
            cells += [f"{value:.3f}" for value in paper.get(agent, ())] or ["", "", ""]
        lines.append(f"| {agent} | {labels.get(agent, '')} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _parts(numbers: Numbers) -> str:
    lines = ["| on episodes of C | ours | paper |", "|---|---|---|"]
    for name, value in asdict(numbers).items():
        shown = f"{value}" if name == "n" else f"{value:.4f}"
        lines.append(f"| {name} | {shown} | {PAPER.get(name, '')} |")
    return "\n".join(lines)


def _trained(cards: Mapping[str, Card]) -> str:
    lines = ["| agent | episodes | windows | updates | width | size |", "|---" * 6 + "|"]
    for agent, card in cards.items():
        size = sum(entry.bytes for entry in card.files) / 1e6
        of = card.training
        lines.append(f"| {agent} | {of.episodes} | {of.windows} | {of.updates} | {card.policy.width} | {size:.1f} MB |")
    return "\n".join(lines)
