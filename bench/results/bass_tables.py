"""The paper's tables of "BASS Analysis", with a column for each of our agents."""

from collections.abc import Mapping
from typing import NamedTuple

from movingout.agents.bass.agent import BassAgent, OracleBassAgent, RandomPartnerBassAgent
from movingout.agents.checkpoint.checkpoint import MODEL_ROOTS, find_checkpoint

BASS, GRU = "BASS", "BASS (GRU)"
RANDOM, ORACLE = "BASS (Random partner action)", "BASS w/ Oracle Simulator"
EVERYBODY = (BASS, GRU, RANDOM, ORACLE)


class Row(NamedTuple):
    """One row of a table."""

    label: str  # as in the paper, where it has such a row
    paper: tuple[float, float] | None  # in Challenge 1 and 2
    field: str  # of `bench.bass.Numbers`; empty where we measure nothing like it
    roles: tuple[str, ...] = EVERYBODY  # the agents that the row applies to


TABLES = {
    "Next-state prediction: L2 norm, lower is better (`tab:next_state_pred`)": (
        Row("BASS", (0.0010, 0.0028), "next_state_l2", (BASS, RANDOM)),
        Row("GRU", (0.0196, 0.0331), "next_state_l2", (GRU,)),
        Row("Random States", (2.7576, 3.2594), "random_state_l2"),
        Row("nothing moves", None, "nothing_moves_l2"),
        Row("BASS, poses alone", None, "poses_l2", (BASS, RANDOM)),
        Row("GRU, poses alone", None, "poses_l2", (GRU,)),
        Row("nothing moves, poses alone", None, "nothing_moves_poses_l2"),
        Row("share of grasps and releases predicted", None, "hands"),
    ),
    'Partner action prediction: share within the tolerance ("Partner Action Prediction Accuracy")': (
        Row("10 % error tolerance", (0.7145, 0.7145), "partner_10"),
        Row("20 % error tolerance", (0.9024, 0.9024), "partner_20"),
    ),
    "Action selection: agreement with the engine (`tab:random_partner`, `tab:next_state_models`)": (
        Row(BASS, (0.6250, 0.4870), "selection", (BASS,)),
        Row(RANDOM, (0.2542, 0.2484), "selection", (RANDOM,)),
        Row(GRU, (0.2487, 0.2598), "selection", (GRU,)),
        Row("BASS (qVAE)", (0.3102, 0.2722), ""),
        Row(ORACLE, (1.0, 1.0), "selection", (ORACLE,)),
        Row("chance", None, "selection_chance"),
        Row("where the engine tells candidates apart", None, "selection_told_apart"),
        Row("moments", None, "n"),
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
    dynamics = find_checkpoint(agent_id.partition(":")[0], *MODEL_ROOTS).card.dynamics
    return GRU if dynamics and dynamics.kind == "gru" else BASS


def tables(measured: Mapping[str, Mapping[str, float]], roles: Mapping[str, str], challenge: int) -> str:
    """Markdown tables of the paper's figures and of those `measured` for each agent, in the rows of its role."""
    parts = []
    for title, rows in TABLES.items():
        lines = [f"**{title}**\n", f"| Challenge {challenge} | paper | " + " | ".join(measured) + " |"]
        lines.append("|---" * (2 + len(measured)) + "|")
        for row in rows:
            cells = ["" if row.paper is None else f"{row.paper[challenge - 1]:.4f}"]
            cells += [_cell(numbers, row, roles[agent_id]) for agent_id, numbers in measured.items()]
            lines.append(f"| {row.label} | " + " | ".join(cells) + " |")
        parts.append("\n".join(lines))
    return "\n\n".join([*parts, FOOT])


def _cell(numbers: Mapping[str, float], row: Row, of: str) -> str:
    if of not in row.roles or not row.field:
        return ""
    value = numbers[row.field]
    return str(value) if isinstance(value, int) else f"{value:.4f}"
