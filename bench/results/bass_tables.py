"""The paper's tables of "BASS Analysis", with a column for each of our agents."""

from collections.abc import Mapping
from typing import NamedTuple

from movingout.agents.bass.agent import BassAgent, RandomPartnerBassAgent
from movingout.agents.bass.engine_agent import OracleBassAgent
from movingout.agents.checkpoint.checkpoint import find_checkpoint, model_roots
from movingout.matches.paper.published import figure

BASS, GRU = "BASS", "BASS (GRU)"
RANDOM, ORACLE = "BASS (Random partner action)", "BASS w/ Oracle Simulator"
EVERYBODY = (BASS, GRU, RANDOM, ORACLE)


class Row(NamedTuple):
    """One row of a table."""

    label: str  # as in the paper, where it has such a row
    field: str  # of `agents.bass.accuracy.BassAccuracy`; empty where we measure nothing like it
    roles: tuple[str, ...] = EVERYBODY  # the agents that the row applies to
    paper: tuple[str, str, str, str] | None = None  # label, group, row and measure in matches/paper/published.yaml


def _next_state(row: str) -> tuple[str, str, str, str]:
    return "tab:next_state_pred", "", row, "next_state_l2"


def _partner(measure: str) -> tuple[str, str, str, str]:
    return "text:partner_prediction", "", BASS, measure


TABLES = {
    "Next-state prediction: L2 norm, lower is better (`tab:next_state_pred`)": (
        Row("BASS", "next_state_l2", (BASS, RANDOM), _next_state("BASS")),
        Row("GRU", "next_state_l2", (GRU,), _next_state("GRU")),
        Row("Random States", "random_state_l2", paper=_next_state("Random States")),
        Row("nothing moves", "nothing_moves_l2"),
        Row("BASS, poses alone", "poses_l2", (BASS, RANDOM)),
        Row("GRU, poses alone", "poses_l2", (GRU,)),
        Row("nothing moves, poses alone", "nothing_moves_poses_l2"),
        Row("share of grasps and releases predicted", "hands"),
    ),
    'Partner action prediction: share within the tolerance ("Partner Action Prediction Accuracy")': (
        Row("10 % error tolerance", "partner_10", paper=_partner("partner_10")),
        Row("20 % error tolerance", "partner_20", paper=_partner("partner_20")),
    ),
    "Action selection: agreement with the engine (`tab:random_partner`, `tab:next_state_models`)": (
        Row(BASS, "selection", (BASS,), ("tab:random_partner", "BASS", BASS, "selection")),
        Row(RANDOM, "selection", (RANDOM,), ("tab:random_partner", "BASS", RANDOM, "selection")),
        Row(GRU, "selection", (GRU,), ("tab:next_state_models", "", GRU, "selection")),
        Row("BASS (qVAE)", "", paper=("tab:next_state_models", "", "BASS (qVAE)", "selection")),
        Row(ORACLE, "selection", (ORACLE,), ("tab:random_partner", "BASS", ORACLE, "selection")),
        Row("chance", "selection_chance"),
        Row("where the engine tells candidates apart", "selection_told_apart"),
        Row("moments", "n"),
    ),
}
FOOT = (
    "L2 is over our state vector: poses, speeds in u/s, and what each hand holds, one-hot, so that one wrong hand "
    "costs 1.41. The paper says neither what its state contains nor how it is scaled, nor how its random states "
    "are drawn (ours are from other moments of the episode); so compare the rows of a column, not the columns. "
    "Poses alone: x, y, cos and sin of the angle of both robots and all items. For partner action prediction the "
    "paper gives one figure for both challenges."
)


def role(agent_id: str, agent: BassAgent) -> str:
    """The name of such an agent in these tables of the paper."""
    if isinstance(agent, RandomPartnerBassAgent):
        return RANDOM
    if isinstance(agent, OracleBassAgent):
        return ORACLE
    dynamics = find_checkpoint(agent_id.partition(":")[0], *model_roots()).card.dynamics
    return GRU if dynamics and dynamics.kind == "gru" else BASS


def tables(measured: Mapping[str, Mapping[str, float]], roles: Mapping[str, str], challenge: int) -> str:
    """Markdown tables of the paper's figures and of those `measured` for each agent, in the rows of its role."""
    parts = []
    for title, rows in TABLES.items():
        lines = [f"**{title}**\n", f"| Challenge {challenge} | paper | " + " | ".join(measured) + " |"]
        lines.append("|---" * (2 + len(measured)) + "|")
        for row in rows:
            cells = [_theirs(row, challenge)]
            cells += [_cell(numbers, row, roles[agent_id]) for agent_id, numbers in measured.items()]
            lines.append(f"| {row.label} | " + " | ".join(cells) + " |")
        parts.append("\n".join(lines))
    return "\n\n".join([*parts, FOOT])


def _cell(numbers: Mapping[str, float], row: Row, of: str) -> str:
    if of not in row.roles or not row.field:
        return ""
    value = numbers[row.field]
    return str(value) if isinstance(value, int) else f"{value:.4f}"


def _theirs(row: Row, challenge: int) -> str:
    """The paper's figure; where it gives one for both challenges, in both."""
    if row.paper is None:
        return ""
    label, group, name, measure = row.paper
    found = figure(label, group, name, (challenge, measure)) or figure(label, group, name, (1, measure))
    return "" if found is None else found.text
