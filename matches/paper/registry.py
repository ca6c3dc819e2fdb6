"""Every label of the paper, in its order: which agents, matches and measurements fill its cells.

A label that is missing here is missing in `movingout paper list`; a new one is an entry in `published.yaml` for the
paper's numbers and one here for ours.
"""

from collections.abc import Mapping, Sequence

from movingout.maps.suggestion import probably_meant
from movingout.matches.errors import MatchError
from movingout.matches.paper.cells import EmptyCell
from movingout.matches.paper.entry import Earlier, PaperEntry, RowCells
from movingout.matches.paper.methods import NOISE_LEVELS, ORDER_MAPS, PICTURE_MAP
from movingout.matches.paper.other_labels import NO_PEOPLE, OTHER_LABELS
from movingout.matches.paper.published import PublishedRow
from movingout.matches.paper.rows.diversity import augmented_cell, diversity_cell, equal_cell, equal_maps, recorded_maps
from movingout.matches.paper.rows.measurements import accuracy, noise_episodes
from movingout.matches.paper.rows.method_rows import (
    bass_zero_shot,
    by_challenge,
    named_rows,
    noise,
    recombined,
    seen,
    self_play,
    unseen,
)
from movingout.matches.paper.rows.reinforced import (
    played_diversity,
    reinforced_seen,
    reinforced_unseen,
    reinforced_varied,
    zero_shot,
)

SELF_PLAY = (
    "Pairs of one agent with itself, trained on the episodes of the challenge, but for those kept for validation: in "
    "Challenge 1 of one in ten people, in Challenge 2, of simulators alone, one in ten."
)
SEEN_AND_ALL = (
    "Challenge 1: as the rows Seen of tab:task_1_results, whose numbers the paper repeats here; Challenge 2: pairs of "
    "one agent with itself, trained on its episodes."
)
OF_BOTH = (
    "Prediction and selection are measured for blue, in episodes of pairs in turn: in Challenge 1 with agents of group "
    "a on episodes of group b; in Challenge 2 on the maps that agents are evaluated on, played by people whom they did "
    "not learn from (where nobody else played, by those). Of a selection, only moments count in which the engine tells "
    "the candidates apart. The paper calls the accuracy of selections prediction accuracy in two of its tables: "
    "whether the learned simulator chooses as the engine would."
)

ACCURACY = (
    "accuracy: on episodes of pairs in turn that the agents did not learn from, in moments in which the engine tells "
    "candidates apart"
)
COMPUTED = (
    "at `small` and `medium`, simulators predict how the robots move; hands and held items are computed, in all rows "
    "alike (`--rigid no --grasping no` predicts them, as the paper does)"
)
RANDOM_PARTNER = (
    "random partner: each number of each tick is drawn by itself, from -1 to 1, so that it hardly gets anywhere while "
    "its hand opens and closes; the paper does not say how it draws"
)
ONE_PAIR = Earlier(
    "2026-11-28",
    "The numbers of simulator, partner and choice here were measured before 2026-11-28: in 24 episodes of one pair, "
    "and in Challenge 2 of people that the agents had learned from.",
)
FRAMES = (
    "The paper's learned from 30,000,000 frames each, ours from as many as the budget says, up to `medium` with the "
    "settings of `--preset fast`, which are not the paper's."
)
_NAMES = {"MLP": "mlp", "GRU": "gru", "DP": "dp", "DP/BASS": "bass"}
_GROUPS: Mapping[tuple[str, str], RowCells] = {
    **{("Seen", name): seen(method) for name, method in _NAMES.items()},
    **{("Unseen", name): unseen(method) for name, method in _NAMES.items()},
    ("Seen", "MAPPO"): reinforced_seen,
    ("Unseen", "MAPPO"): reinforced_unseen,
}
_METHODS: Mapping[tuple[str, str], RowCells] = {
    ("MLP", "MLP"): self_play("mlp"),
    ("MLP", "+ BASS w/o Simulation"): self_play("mlp-augmented"),
    ("GRU", "GRU"): self_play("gru"),
    ("GRU", "+ BASS w/o Simulation"): self_play("gru-augmented"),
    ("GRU", "+ BASS w/o Augmentation"): self_play("bass-on-gru-plain"),
    ("GRU", "+ Full BASS"): self_play("bass-on-gru"),
    ("DP", "Diffusion Policy (DP)"): self_play("dp"),
    ("DP", "+ BASS w/o Simulation"): self_play("dp-augmented"),
    ("DP", "+ BASS w/o Augmentation"): self_play("bass-plain"),
    ("DP", "+ Full BASS"): self_play("bass"),
}
_BASS, _ORACLE = self_play("bass"), self_play("bass", ":simulator=oracle")
_CROSS = (
    "Seen: two agents of each method, each with itself, trained on disjoint halves of the participants; unseen: one "
    "with the other. WT is the share of ticks that the official code counts."
)

_ZERO_SHOT = (
    "Seen: agents with themselves, of DP/BASS one of each group of participants, of MAPPO and CoMeDi one from each of "
    "two seeds, which learn from no episodes. Unseen: DP/BASS of group a with DP/BASS of group b; MAPPO and CoMeDi "
    "with DP of group b, which stands for people. " + FRAMES
)

REINFORCED = (
    "MAPPO and CoMeDi have an agent for each map and learn from no episodes; a second seed takes the place of the "
    "second group. " + FRAMES
)


VARIED_REINFORCED = (
    "The paper prints no numbers for MAPPO in Challenge 2. Ours has an agent for each map, which plays another variant "
    "in every episode and learns from no recordings."
)


RECOMBINED = (
    "Diversity is that of whole episodes: from a matching stretch on, the partner goes the rest of its way in the "
    "other episode, as in the paper's example, and the path ends where that way does. The paper's method and what "
    "agents learn from here (8 ticks) exchange the stretch alone. Beside the recorded episodes stand up to four times "
    "as many recombined ones (of all of them 24 per map), which share the way of one robot with a recorded one; sets "
    "of other sizes are not alike in spread and entropy. No value: no map has three, or, of valid, no two episodes "
    "have a matching stretch."
)


SINGLE = "Recombined, single-agent"  # as in tab:w1_recombination
_NO_PIECES = EmptyCell("recorded episodes are valid by themselves")


_ENTRIES: tuple[PaperEntry, ...] = (
    PaperEntry(
        label="table:task_1_diversity", kind="table",
        notes=(
            "Means over maps, of equally many episodes of each population; the experts' episodes are those of "
            "Challenge 2, on variants of the maps. A map of which one population has fewer than three episodes is left "
            "out.",
        ),
        folder_notes=equal_maps,
        differs="units and kernels are ours, the paper gives none: compare rows; `movingout recordings diversity` "
        "measures any recordings, with means over draws",
        rows=named_rows(**{
            "Moving Out Challenge 1": lambda column: equal_cell("c1", column.measure),
            "Expert dataset": lambda column: equal_cell("c2", column.measure),
            "RL agent collected data": lambda column: played_diversity(column.measure),
        }),
    ),
    PaperEntry(
        label="table:task_1_results", kind="table",
        differs="the rows with people need a study",
        rows=_GROUPS, otherwise=NO_PEOPLE, against={"Unseen": "Seen"},
        grouping="column", row_heads=("Evaluation Protocol", "Method"),
        notes=(_CROSS, REINFORCED),
    ),
    PaperEntry(
        label="tab:task_1_results", kind="table",
        differs="the rows with people need a study",
        rows=_GROUPS, otherwise=NO_PEOPLE, against={"Unseen": "Seen"},
        grouping="column", row_heads=("Evaluation Protocol", "Method"),
        notes=(_CROSS, REINFORCED),
    ),
    PaperEntry(
        label="tab:cross_group_eval", kind="table",
        differs="groups of participants drawn at random, as in the paper",
        against={"Cross-Group": "Same-Group"}, notes=(_CROSS,), grouping="column", row_heads=("Setting", "Method"),
        rows={
            ("Same-Group", "DP"): seen("dp"), ("Same-Group", "DP/BASS"): seen("bass"),
            ("Cross-Group", "DP"): unseen("dp"), ("Cross-Group", "DP/BASS"): unseen("bass"),
        },
    ),
    PaperEntry(
        label="fig:results_t2", kind="figure", notes=(SELF_PLAY, VARIED_REINFORCED),
        differs="the paper prints no numbers for MAPPO in Challenge 2; ours learns from another variant in every "
        "episode",
        lacks="the paper's bars of play with people in Challenge 2 need a study, with the template `paper`",
        rows={
            **{("Challenge 2", name): self_play(method) for name, method in _NAMES.items()},
            ("Challenge 2", "MAPPO"): reinforced_varied,
        },
        extra_rows=(PublishedRow("Challenge 2", "MAPPO", {}),),
    ),
    PaperEntry(
        label="tab:ablation", kind="table",
        differs="candidates of a GRU: the paper does not say how it draws them; ours are perturbed chunks",
        rows={key: row for key, row in _METHODS.items() if key[0] != "MLP"},
               notes=(SELF_PLAY,)),
    PaperEntry(
        label="tab:full_results_in_t1", kind="table",
        differs="candidates of a GRU as in tab:ablation",
        rows=_METHODS, notes=(SELF_PLAY,)),
    PaperEntry(
        label="tab:full_results_in_t2", kind="table",
        differs="candidates of a GRU as in tab:ablation",
        rows=_METHODS, notes=(SELF_PLAY,)),
    PaperEntry(
        label="tab:simulator", kind="table",
        differs=f"{ACCURACY}; {COMPUTED}",
        notes=(SELF_PLAY, OF_BOTH), earlier=ONE_PAIR,
        rows=named_rows(**{"DP + BASS": _BASS, "DP + BASS w/ Oracle Simulator": _ORACLE}),
    ),
    PaperEntry(
        label="tab:zsc_comparison", kind="table",
        differs="MAPPO, CoMeDi: seen is self-play, unseen is with DP of group b, which stands for people, while "
        "DP/BASS plays with DP/BASS of group b; the paper has no numbers for CoMeDi's training: ours are two or three "
        "conventions, weights of 0.3",
        rows=named_rows(**{"DP/BASS": bass_zero_shot, "MAPPO": zero_shot("mappo"), "CoMeDi": zero_shot("comedi")}),
        notes=(_ZERO_SHOT,),
    ),
    PaperEntry(
        label="tab:image_bass", kind="table",
        differs="pictures of 128 x 128; those who see them learn from map 6 alone, without pose noise, and BASS "
        "chooses by learned progress",
        notes=(SELF_PLAY, "Map 6 is DistancePriority; agents that see pictures learn from its episodes alone."),
        rows=named_rows(**{
            "DP (State)": self_play("dp", maps=(PICTURE_MAP,)),
            "DP/BASS (State)": self_play("bass", maps=(PICTURE_MAP,)),
            "DP (Image)": self_play("dp-image", maps=(PICTURE_MAP,)),
            "DP/BASS (Image)": self_play("bass-image", maps=(PICTURE_MAP,)),
        }),
    ),
    PaperEntry(
        label="tab:sampling_comparison", kind="table", notes=(SELF_PLAY,),
        rows={
            ("BASS", "Sample 4x independently"): _BASS,
            ("BASS", "2x2 combination"): self_play("bass", ":sampling=2x2"),
            ("BASS", "4x4 combination"): self_play("bass", ":sampling=4x4"),
        },
    ),
    PaperEntry(
        label="tab:random_partner", kind="table",
        differs=f"{RANDOM_PARTNER}; {ACCURACY}",
        notes=(SELF_PLAY, OF_BOTH), earlier=ONE_PAIR,
        rows={
            ("BASS", "BASS"): _BASS,
            ("BASS", "BASS (Random partner action)"): self_play("bass", ":partner=random"),
            ("BASS", "BASS w/ Oracle Simulator"): _ORACLE,
        },
    ),
    PaperEntry(
        label="tab:next_state_models", kind="table", notes=(SELF_PLAY, OF_BOTH), earlier=ONE_PAIR,
        differs=f"{COMPUTED}; a qVAE of our own making: the paper gives no sizes; accuracy as in tab:simulator",
        rows=named_rows(**{
            "BASS": _BASS, "BASS (GRU)": self_play("bass-gru-dynamics"), "BASS (qVAE)": self_play("bass-qvae-dynamics"),
            "BASS w/ Oracle Simulator": _ORACLE,
        }),
    ),
    PaperEntry(
        label="text:autoencoder_order", kind="sentence",
        differs=f"all three predict the state itself, not its change; {COMPUTED}",
        notes=(SELF_PLAY, "All three predict the state itself, as in the paper, not its change, but of robots alone."),
        rows=named_rows(**{
            "Joint training": self_play("bass-joint", maps=ORDER_MAPS),
            "Fine-tuning the second AE from the first AE": self_play("bass-fine-tuned", maps=ORDER_MAPS),
            "Training two AEs separately": self_play("bass-separate", maps=ORDER_MAPS),
        }),
    ),
    PaperEntry(
        label="tab:w1_recombination", kind="table",
        differs="single-agent: either end matches, and pieces are put together without the engine (`train --matching "
        "either-end --confirm no`); diversity: recombined paths go on in the other episode to its end",
        otherwise="",
        notes=("Each with itself. All three have no pose noise, so that recombination alone differs.", RECOMBINED),
        folder_notes=recorded_maps,
        rows=named_rows(**{
            "Multi-agent Recombination": recombined("dp-recombined", "both-ends"),
            "Single-agent Recombination": recombined("dp-recombined-single", "either-end"),
            "No Recombination": recombined("dp"),
        }),
    ),
    PaperEntry(
        label="tab:pose_noise_ablation", kind="table",
        row_heads=("Noise (σ)",),
        differs='the paper does not define "valid"; ours: it can be staged, hands as recorded, ends within 0.06 u '
        'over 8 ticks',
        notes=(
            "Map 10 is SingleRotation; agents learn from its episodes alone and play with themselves. States of an "
            "episode count together in the ± of valid; of scripted people, `small` has eight episodes.",
        ),
        folder_notes=noise_episodes,
        rows=named_rows(**{level: noise(level) for level in NOISE_LEVELS}),
    ),
    PaperEntry(
        label="tab:next_state_pred", kind="table",
        differs="L2 over our state vector; compare rows, not columns; Random States: another moment of the same "
        f"episode; {COMPUTED}",
        notes=(OF_BOTH, "L2 over our state vector, so compare the rows of a column, not the columns."),
        earlier=ONE_PAIR,
        rows=named_rows(**{
            "BASS": _BASS, "GRU": self_play("bass-gru-dynamics"),
            "Random States": lambda column: accuracy("bass", "", column.challenge, "random_state_l2"),
        }),
    ),
    PaperEntry(
        label="text:partner_prediction", kind="sentence",
        differs="relative error of the mean of four samples",
        rows=named_rows(BASS=_BASS), notes=(OF_BOTH,), earlier=ONE_PAIR),
    PaperEntry(
        label="tab:nfd_vs_ac", kind="table",
        differs="the weight of AC is ours (0.05); the paper gives none",
        notes=(SELF_PLAY,),
        rows=named_rows(**{"BASS with NFD": _BASS, "BASS with NFD+AC": self_play("bass", ":score=nfd+ac")}),
    ),
    PaperEntry(
        label="tab:w1_simulation", kind="table",
        differs="single-agent: the partner is taken to stand still and to keep what it holds",
        notes=(SELF_PLAY, "Single-agent: the partner is taken to stand still."),
        rows=named_rows(**{
            "Multi-agent Action Simulation": self_play("bass-plain"),
            "Single-agent Action Simulation": self_play("bass-plain", ":partner=none"),
            "No Action Simulation": self_play("dp"),
        }),
    ),
    PaperEntry(
        label="tab:tcl_results", kind="table", notes=(SEEN_AND_ALL,),
        differs="the loss is that of R3M on our state vector; the paper gives none",
        rows=named_rows(**{
            name: by_challenge(seen(method), self_play(method))
            for name, method in {"DP/BASS": "bass", "DP/BASS w/ reward estimation": "bass-tcl", "DP": "dp"}.items()
        }),
    ),
    PaperEntry(
        label="text:augmentation", kind="sentence", notes=(RECOMBINED,), folder_notes=recorded_maps,
        differs="recombined paths go on in the other episode to its end, as in the paper's example; valid: the engine "
        "plays the piece and ends within 0.06 u",
        rows=named_rows(**{
            "Recorded": lambda column: (
                diversity_cell("c1", column.measure) if column.measure == "entropy" else _NO_PIECES
            ),
            "Recombined": lambda column: augmented_cell("both-ends", column.measure),
            SINGLE: lambda column: augmented_cell("either-end", column.measure),
        }),
        extra_rows=(PublishedRow("", SINGLE, {}),),
    ),
    *OTHER_LABELS,
)  # fmt: skip
ENTRIES: Mapping[str, PaperEntry] = {entry.label: entry for entry in _ENTRIES}
"""By label."""


def chosen_entries(labels: Sequence[str]) -> list[PaperEntry]:
    """The entries of these labels, each once; with `all` among them, every one that can be made with all extras
    installed.

    Raises MatchError for a label that is unknown.
    """
    for label in labels:
        if label != "all" and label not in ENTRIES:
            meant = probably_meant(label, ENTRIES) or ";"
            raise MatchError(f"the paper has no label {label!r}{meant} `movingout paper list` has all")
    if "all" in labels:
        return [entry for entry in ENTRIES.values() if entry.runnable or entry.extra]
    return [ENTRIES[label] for label in dict.fromkeys(labels)]
