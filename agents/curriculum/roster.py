"""The agents that the recipe trains, and their names. `@all` learned from people of A and B, `@a` from those of A."""

DP, AUGMENTED, MLP, GRU = "dp@all", "dp-augmented@all", "mlp@all", "gru@all"
BASS, PLAIN = "bass@all", "bass-plain@all"  # on top of AUGMENTED, and on top of DP
FIRST = "bass-first@all"  # BASS with a value that has not seen itself play yet
LEARNER = "dp-rounds@all"  # DP that is trained on from round to round, and shows where labels are needed

DP_A, AUGMENTED_A, MLP_A, GRU_A = "dp@a", "dp-augmented@a", "mlp@a", "gru@a"
BASS_A, PLAIN_A = "bass@a", "bass-plain@a"  # choose by NFD, as in the paper

NAMES = {
    LEARNER: "Diffusion Policy between the rounds",
    DP: "Diffusion Policy",
    AUGMENTED: "DP with augmentation",
    BASS: "DP/BASS",
    PLAIN: "DP with simulation",
    FIRST: "DP/BASS, its first value",
    MLP: "MLP",
    GRU: "GRU",
    DP_A: "Diffusion Policy, A alone",
    AUGMENTED_A: "DP with augmentation, A alone",
    BASS_A: "DP/BASS, A alone",
    PLAIN_A: "DP with simulation, A alone",
    MLP_A: "MLP, A alone",
    GRU_A: "GRU, A alone",
}
