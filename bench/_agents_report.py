"""The measured part of docs/results.md: tables made from outcomes, beside the paper's.

The page has words around it that people write; what is between the two marks is replaced.
"""

import datetime
import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

from agents.checkpoint import Card
from bench.bass import PAPER, Numbers
from bench.learning import Outcome, mean_error, shown, table
from maps import map_names

BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"
TARGET_TCR = 0.65
PAPER_UNSEEN = {  # the paper's Challenge 1, unseen behaviours: TCR, NFD, AC
    "mlp@all": (0.1433, 0.2413, 0.7729),
    "gru@all": (0.1638, 0.2453, 0.7830),
    "dp@all": (0.2563, 0.4589, 0.7854),
    "bass@all": (0.3010, 0.5197, 0.8099),
}
PAPER_PEOPLE = {"dp@all": (0.3855, 0.5547, 0.8054), "bass@all": (0.6512, 0.7053, 0.9124)}  # with real people


def write_report(path: Path, measured: str) -> None:
    """Put `measured` between the marks of the page; a page without them gets them at its end."""
    page = path.read_text(encoding="utf-8") if path.exists() else "# Results\n\n"
    before, begin, rest = page.partition(BEGIN)
    after = rest.partition(END)[2] if begin else "\n"
    path.write_text(f"{before}{BEGIN}\n{measured}\n{END}{after}", encoding="utf-8")


def measured_part(
    outcomes: Mapping[str, Sequence[Outcome]],
    labels: Mapping[str, str],
    cards: Mapping[str, Card],
    numbers: Numbers | None,
) -> str:
    """Everything between the marks.

    `outcomes` by what the partners are, the people never trained with first; `labels` names the learned agents as the
    paper does, `cards` are theirs.
    """
    today = datetime.datetime.now(datetime.UTC).date().isoformat()
    unseen = next(iter(outcomes.values()))
    agents = list(dict.fromkeys(one.run.agent for one in unseen))
    parts = [
        f"Measured on {today}, {platform.machine()}, {os.cpu_count()} cores, by `python -m bench.train_agents`.",
        f"Partners are scripted people; {unseen[0].run.ticks} ticks, all maps alike; errors are standard errors over "
        "episodes. `idle` is the control: what these people reach alone; `scripted` is the expert that the others "
        "learned from.",
    ]
    for partners, played in outcomes.items():
        parts += [f"## With {partners}", table(list(played), agents, list(map_names()))]
    parts += [
        "## Beside the paper (Challenge 1)",
        _beside_paper(unseen, agents, labels),
        "Their partners were policies and people, ours are scripted people of C: the columns show the order of "
        "methods, not who is better.",
        "## Against the aim, and against the base policy",
        "\n".join(f"- {line}" for line in verdicts(unseen)),
        *(["## The parts of BASS", _parts(numbers)] if numbers else []),
        "## What was trained",
        _trained(cards),
    ]
    return "\n\n".join(parts)


def verdicts(outcomes: Sequence[Outcome]) -> list[str]:
    """What was aimed at, and by how much it was reached or missed."""
    lines = []
    tcr, error = mean_error([one.tcr for one in outcomes if one.run.agent == "bass@all"])
    reached = "reached" if tcr >= TARGET_TCR else f"missed by {TARGET_TCR - tcr:.3f}"
    lines.append(f"`bass@all` TCR {tcr:.3f} ± {error:.3f}; aimed at {TARGET_TCR}: {reached}.")
    for name in ("tcr", "nfd"):
        mean, error = mean_error(gains(outcomes, "bass@all", "dp@all", name))
        lines.append(
            f"{name.upper()} of BASS minus DP, the same partner, map, seat and seed: {mean:+.3f} ± {error:.3f}."
        )
    return lines


def gains(outcomes: Sequence[Outcome], one: str, other: str, metric: str) -> list[float]:
    """Differences of a metric between two agents over the episodes that both played."""

    def of(agent: str) -> dict[tuple[object, ...], float]:
        return {
            (o.run.partner, o.run.map, o.run.seat, o.run.seed): getattr(o, metric)
            for o in outcomes
            if o.run.agent == agent
        }

    mine, theirs = of(one), of(other)
    return [mine[key] - theirs[key] for key in mine if key in theirs]


def _beside_paper(outcomes: Sequence[Outcome], agents: Sequence[str], labels: Mapping[str, str]) -> str:
    of = "TCR | NFD | AC"
    head = f"| agent | as in the paper | ours: {of} | paper, unseen AI: {of} | paper, people: {of} |"
    lines = [head, "|---" * 11 + "|"]
    for agent in agents:
        mine = [one for one in outcomes if one.run.agent == agent]
        ours = [
            mean_error([v for one in mine if (v := getattr(one, name)) is not None]) for name in ("tcr", "nfd", "ac")
        ]
        cells = [shown(*pair) for pair in ours]
        for paper in (PAPER_UNSEEN, PAPER_PEOPLE):
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
