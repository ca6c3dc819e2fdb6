"""The agents in the tables of docs/twelve-maps.md, their names in the paper and where it gives their scores."""

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
"""Options that make a BASS agent choose by NFD, as in the paper, instead of by a value."""
PAPER_BASS, SIMULATED = f"{BASS}:{PAPER_CHOICE}", f"{PLAIN}:{PAPER_CHOICE}"
CHOOSING_BY_NFD = (PAPER_BASS, SIMULATED)
SCRIPTED, CONTROL = "scripted", "idle"


class Comparison(NamedTuple):
    """Agents trained with the same people, and the partners they are evaluated with."""

    learners: dict[str, str]
    """Names in the paper, by agent id."""
    partners: dict[str, str]
    """What each population is to these agents, by name; C is never trained with."""
    compared: tuple[tuple[str, str], ...]
    """Pairs (agent, baseline) whose difference is reported."""


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
"""Where the paper reports such agents in Challenge 1, by column of our table and agent: table and row in
`matches.experiment.paper_reference`."""
