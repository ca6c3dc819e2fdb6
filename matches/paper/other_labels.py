"""Labels of the paper that are no tables of agents: sentences, pictures, and what needs people or is not made here."""

from movingout.agents.overcooked.kitchen import MISSING
from movingout.matches.paper.entry import PaperEntry
from movingout.matches.paper.other_games.overcooked import ROWS, overcooked_row
from movingout.matches.paper.presentation.drawing import Drawing
from movingout.matches.paper.presentation.pictures import (
    positions,
    randomized,
    recombination_example,
    rollouts,
    tcl_distances,
)
from movingout.matches.paper.published import PublishedRow
from movingout.matches.paper.rows.data_sizes import DATA_ROWS, SIZES
from movingout.matches.paper.rows.definitions import MAPPO_ROWS, POLICY_ROWS, REWARD_ROWS
from movingout.matches.paper.rows.measurements import decision_time
from movingout.matches.paper.rows.reinforced import EPISODES, behaviour

ONLY_WHERE = (
    "Times, and what is grasped first, are of the episodes in which it came to that within the time, which n counts: "
    f"of {2 * EPISODES} per map and training, or of twice the budget's matches where those are more. So who seldom "
    "grasps may look quick."
)
NO_PEOPLE = "needs people: a study with the template `paper`, then its report"

_SENTENCES = (
    PaperEntry(
        label="text:inference_time", kind="sentence", differs="on one core of a CPU, with the networks of the budget",
        rows={
            ("", "Sample 4x independently"): lambda _: decision_time("bass", ":sampling=4"),
            ("", "4x4 combination"): lambda _: decision_time("bass", ":sampling=4x4"),
        },
    ),
    PaperEntry(
        label="text:overcooked", kind="sentence", otherwise=MISSING,
        own_episodes=True, extra="overcooked",
        differs="learned from the games of 16 pairs of people that come with the package; the paper tells neither data "
        "nor sizes nor score; ours is the number of soups expected; a perturbed partner is turned or a tile away",
        rows={("", name): overcooked_row(who) for name, who in ROWS.items()},
        extra_rows=tuple(PublishedRow("", name, {}) for name in ROWS if name != "DP + BASS"),
        notes=(
            "Cramped Room, 400 ticks, both cooks alike, 20 points a soup; the change of the mean score, n counts games "
            "of both. Score above DP's: game by game, with the same noise; valid: recombined stretches that the "
            "kitchen plays as they were recorded.",
            "They learned from 16 games of pairs of people of 2019, and have sizes of their own: "
            "`matches/paper/other_games/overcooked.py`.",
        ),
    ),
    PaperEntry(
        label="mappo_parameters", kind="table", rows=MAPPO_ROWS, own_episodes=True, grouping="line",
        row_heads=("Parameter Name",),
        differs="the settings of `train mappo --preset paper`; the paper's five of target networks and exploration do "
        "nothing in MAPPO",
    ),
    PaperEntry(
        label="text:policy_parameters", kind="sentence", rows=POLICY_ROWS, own_episodes=True, grouping="line",
        row_heads=("Parameter",),
        differs="the settings of `--preset paper`; encoders and decoders have a linear layer more than the paper's; "
        "what the paper does not say, as a moving average of the weights, stands above",
    ),
    PaperEntry(
        label="text:data_sets", kind="sentence", rows=DATA_ROWS, own_episodes=True, grouping="line",
        row_heads=("Size",),
        differs="the sizes of the budget `full`, for scripted people, who finish; smaller budgets have fewer; with "
        "`--data` those of the recordings; a tenth of the people of Challenge 1 is kept for validation",
        notes=(SIZES,),
    ),
    PaperEntry(
        label="text:training_time", kind="sentence",
        otherwise="needs the paper's GPU; `paper tables LABEL --budget full --dry-run` says how long; "
        "docs/reproduction-findings.md has times of U-Nets on an NVIDIA H200",
    ),
    PaperEntry(
        label="text:sparse_reward", kind="sentence",
        differs="the paper has no numbers here; ours is on map 6 and has the paper's events and step costs, without "
        "distances (`train mappo --reward paper-sparse`)",
        rows={("", "Dense reward"): behaviour("mappo-{}"), ("", "Sparse reward"): behaviour("mappo-{}-sparse")},
        notes=(
            "Map 6 is DistancePriority; each plays with itself, from two seeds, with the frames of the budget, up to "
            "`medium` with the settings of `--preset fast`, which are not the paper's.",
            ONLY_WHERE,
        ),
    ),
    PaperEntry(
        label="appx:comparsion_BC_RL", kind="sentence",
        differs="the paper has no numbers here; what it says in words is counted in episodes of an agent with itself",
        rows={("", "MAPPO"): behaviour("mappo-{}"), ("", "DP"): behaviour("dp")},
        notes=(
            "Map 6 is DistancePriority, map 11 FourCorners; MAPPO has an agent for each, from two seeds.", ONLY_WHERE,
        ),
    ),
    PaperEntry(
        label="tab:dense_rewards", kind="table", rows=REWARD_ROWS, own_episodes=True, grouping="line",
        row_heads=("Specific Condition",),
        differs="the settings of `world/reward.py`, which says what the paper leaves open",
        notes=(
            "A large rectangle is approached by its short sides on every map; the paper does so on map 11. Row C: "
            "the agent that needs help holds another item than the one released; the paper's words leave that open.",
        ),
    ),
)  # fmt: skip
_OF_PEOPLE = (
    PaperEntry(
        label="fig:human_study_results", kind="figure", otherwise=NO_PEOPLE,
        differs="the paper: p = 0.017 with 32 people, BASS against DP in helpfulness and understanding of physics",
        people=True, command="movingout study report",
    ),
    PaperEntry(
        label="fig:failure_cases", kind="figure", otherwise=NO_PEOPLE, people=True, command="movingout study report",
        differs="rules find them, annotators confirm or reject each",
    ),
)  # fmt: skip
_PICTURES = (
    PaperEntry(
        label="fig:visual_task1", kind="figure", title="Positions of both agents, by pair and in all episodes",
        drawing=Drawing(positions, data=("c1",)),
        notes=("Blue and red dots: where the robots were, every map; of four pairs of participants, and of all.",),
    ),
    PaperEntry(
        label="fig:visual_task2", kind="figure", title="Examples of randomization in Challenge 2",
        drawing=Drawing(randomized),
    ),
    PaperEntry(
        label="fig:rollout_example_task_2", kind="figure", title="Rollouts of BASS, MLP and DP in Challenge 2",
        drawing=Drawing(rollouts, agents=("bass@c2", "mlp@c2", "dp@c2")),
        notes=("SingleRotation, each agent with itself; eight moments from the first tick to the last.",),
    ),
    PaperEntry(
        label="fig:recomb_example", kind="figure", title="An example of recombination",
        differs="one new demonstration, of eight ticks; the paper exchanges the rest of both and has two",
        drawing=Drawing(recombination_example, data=("c1",)),
        notes=("Thick: the eight ticks; the third picture is what the engine makes of them.",),
    ),
    PaperEntry(label="fig:tcl_distance", kind="figure", title="TCL progress estimation",
        differs="unlike the paper's, distances do not only grow: ours follow where the robots are, too",
        drawing=Drawing(tcl_distances, agents=("bass-tcl@a",), data=("a", "b")),
        notes=(
            "Left: five episodes of group a, from which the embedding learned, but for those kept for "
            "validation; right: five of group b.",
        ),
    ),
)  # fmt: skip
_ILLUSTRATIONS = {
    "fig:motivation": "Collaboration in a grid world and in a physical world",
    "fig:introduction": "The environment",
    "fig:physical_interaction": "Physical attributes",
    "fig:collaboration_modes": "Collaboration behaviors",
    "fig:map_examples": "Example maps",
    "fig:method_faas": "Overview of simulation and action selection",
    "fig:ac_calcualtion_example": "Example of action consistency",
    "appx:comparsion": "Comparison with other environments: two tables without a label, of properties and of metrics",
    "tab:maps_coordination": "Maps of coordination; ours: movingout maps list",
    "tab:maps_awareness": "Maps of awareness",
    "tab:maps_action_consistency": "Maps of action consistency",
}
OTHER_LABELS: tuple[PaperEntry, ...] = (
    *_SENTENCES,
    *_OF_PEOPLE,
    *_PICTURES,
    *(
        PaperEntry(label=label, kind="illustration", title=title, differs="an illustration or a description")
        for label, title in _ILLUSTRATIONS.items()
    ),
)
