"""Who is in the tables of docs/results.md, what the paper calls them and what it measured of them."""

from typing import NamedTuple

DP, AUGMENTED, MLP, GRU = "dp@all", "dp-augmented@all", "mlp@all", "gru@all"
BASS, PLAIN = "bass@all", "bass-plain@all"  # on top of AUGMENTED, and on top of DP
FIRST = "bass-first@all"  # BASS with a value that has not seen itself play yet; in no table
LEARNER = "dp-rounds@all"  # DP that goes on from round to round, and shows where labels are needed; likewise
PAPER_CHOICE = "score=nfd,sampling=4x4"
"""Options with which a BASS agent chooses as in the paper, by NFD, instead of by a value."""
PAPER_BASS, SIMULATED = f"{BASS}:{PAPER_CHOICE}", f"{PLAIN}:{PAPER_CHOICE}"
SCRIPTED, CONTROL = "scripted", "idle"

DP_A, AUGMENTED_A, MLP_A, GRU_A = "dp@a", "dp-augmented@a", "mlp@a", "gru@a"
BASS_A, PLAIN_A = "bass@a", "bass-plain@a"  # choose by NFD, as in the paper


class Field(NamedTuple):
    """Agents that learned from the same people, and with whom they play."""

    learners: dict[str, str]
    """Agent ids, and what the paper calls such agents."""
    partners: dict[str, str]
    """Populations, taken in turn, and what they are to these agents; those never trained with are called C."""
    compared: tuple[tuple[str, str], ...]
    """Whose lead over whom is told."""


OF_BOTH = Field(
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
OF_A = Field(
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

PAPER_SEEN = {  # "Results of Different Methods with BASS", Challenge 1, seen behaviours: TCR, NFD, AC
    MLP: (0.3568, 0.4118, 0.7890),
    GRU: (0.3070, 0.3674, 0.7618),
    DP: (0.3829, 0.4818, 0.8395),
    AUGMENTED: (0.4028, 0.5114, 0.8242),
    SIMULATED: (0.4741, 0.5561, 0.8495),
    PAPER_BASS: (0.5027, 0.5707, 0.8615),
}
PAPER_UNSEEN = {  # Challenge 1, unseen behaviours
    MLP: (0.1433, 0.2413, 0.7729),
    GRU: (0.1638, 0.2453, 0.7830),
    DP: (0.2563, 0.4589, 0.7854),
    PAPER_BASS: (0.3010, 0.5197, 0.8099),
}
PAPER_PEOPLE = {DP: (0.3855, 0.5547, 0.8054), PAPER_BASS: (0.6512, 0.7053, 0.9124)}  # with real people
