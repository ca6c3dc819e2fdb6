"""Who is in the tables of docs/results.md, what the paper calls them and what it measured of them."""

from typing import NamedTuple

from movingout.agents.curriculum.roster import (
    AUGMENTED,
    AUGMENTED_A,
    BASS,
    BASS_A,
    DP,
    DP_A,
    GRU,
    GRU_A,
    MLP,
    MLP_A,
    PLAIN,
    PLAIN_A,
)

PAPER_CHOICE = "score=nfd,sampling=4x4"
"""Options with which a BASS agent chooses as in the paper, by NFD, instead of by a value."""
PAPER_BASS, SIMULATED = f"{BASS}:{PAPER_CHOICE}", f"{PLAIN}:{PAPER_CHOICE}"
CHOOSING_BY_NFD = (PAPER_BASS, SIMULATED)
SCRIPTED, CONTROL = "scripted", "idle"


class Comparison(NamedTuple):
    """Agents that learned from the same people, and with whom they play."""

    learners: dict[str, str]
    """Agent ids, and what the paper calls such agents."""
    partners: dict[str, str]
    """Populations, taken in turn, and what they are to these agents; those never trained with are called C."""
    compared: tuple[tuple[str, str], ...]
    """Whose lead over whom is told."""


OF_BOTH = Comparison(
    {
        BASS: "DP/BASS, chosen by value",
        PLAIN: "DP + BASS without augmentation, chosen by value",
        PAPER_BASS: "DP/BASS",
        SIMULATED: "DP + BASS without augmentation",
        AUGMENTED: "DP + BASS without simulation",
        DP: "DP",
        GRU: "GRU",
        MLP: "MLP",
    },
    {"C": "people of C, never trained with"},
    (
        (BASS, DP),
        (BASS, AUGMENTED),
        (PLAIN, DP),
        (BASS, PAPER_BASS),
        (PAPER_BASS, DP),
        (PAPER_BASS, AUGMENTED),
        (SIMULATED, DP),
        (AUGMENTED, DP),
    ),
)
OF_A = Comparison(
    {
        BASS_A: "DP/BASS",
        PLAIN_A: "DP + BASS without augmentation",
        AUGMENTED_A: "DP + BASS without simulation",
        DP_A: "DP",
        GRU_A: "GRU",
        MLP_A: "MLP",
    },
    {
        "A": "people of A, trained with",
        "B": "people of B, another population",
        "C": "people of C, never trained with",
    },
    ((BASS_A, DP_A), (PLAIN_A, DP_A), (AUGMENTED_A, DP_A)),
)

_IN_MAIN_TABLE = {MLP: "MLP", GRU: "GRU", DP: "DP", PAPER_BASS: "DP/BASS"}
_METHODS = "tab:full_results_in_t1, _t2: "
PAPER_COLUMNS = {
    "methods with seen AI": {
        MLP: (f"{_METHODS}MLP", "MLP"),
        GRU: (f"{_METHODS}GRU", "GRU"),
        DP: (f"{_METHODS}DP", "Diffusion Policy (DP)"),
        AUGMENTED: (f"{_METHODS}DP", "+ BASS w/o Simulation"),
        SIMULATED: (f"{_METHODS}DP", "+ BASS w/o Augmentation"),
        PAPER_BASS: (f"{_METHODS}DP", "+ Full BASS"),
    },
    **{
        f"main table, {partners}": {
            agent: (f"tab:task_1_results: {rows}", name) for agent, name in _IN_MAIN_TABLE.items()
        }
        for partners, rows in (("seen AI", "Seen"), ("unseen AI", "Unseen"), ("people", "Play with Human"))
    },
}
"""Where the paper has figures of such agents in Challenge 1, by the columns of our table: table and row of
`matches.experiment.paper_reference`."""
