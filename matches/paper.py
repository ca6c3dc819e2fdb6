"""The paper's figures, to lay beside ours. Copied digit by digit; the names of tables are those of its LaTeX labels.

Their learned agents were trained on people and played with themselves, across groups, or with people. Waiting time is
left out: the paper's figures lie between 0 and 1 and so are no seconds, while its formula and ours give seconds.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple


class Figure(NamedTuple):
    """A mean and, where the paper gives one, its standard error."""

    mean: float
    stderr: float | None = None


Figures = Mapping[str, Figure]
"""By metric: tcr, nfd, ac."""

_METRICS = ("tcr", "nfd", "ac")


def _with_errors(*numbers: float) -> Figures:
    """tcr, its error, nfd, its error, ac, its error."""
    pairs = zip(_METRICS, numbers[::2], numbers[1::2], strict=True)
    return {name: Figure(mean, stderr) for name, mean, stderr in pairs}


def _means(metrics: Sequence[str], *numbers: float) -> Figures:
    return {name: Figure(mean) for name, mean in zip(metrics, numbers, strict=True)}


_T = ("tcr",)
_TN = ("tcr", "nfd")

PAPER: Mapping[tuple[str, int], Mapping[str, Figures]] = {
    # "Full Results for Challenge 1 AI-AI Collaboration"
    ("tab:task_1_results: Seen", 1): {
        "MLP": _with_errors(0.2126, 0.0072, 0.2987, 0.0048, 0.8013, 0.0093),
        "GRU": _with_errors(0.2369, 0.0183, 0.3011, 0.0142, 0.8151, 0.0173),
        "MAPPO": _with_errors(0.1929, 0.0038, 0.3182, 0.0045, 0.8097, 0.0071),
        "DP": _with_errors(0.3233, 0.0279, 0.5367, 0.0151, 0.8163, 0.0162),
        "DP/BASS": _with_errors(0.3503, 0.0293, 0.5724, 0.0232, 0.8337, 0.0146),
    },
    ("tab:task_1_results: Unseen", 1): {
        "MLP": _with_errors(0.1433, 0.0061, 0.2413, 0.0033, 0.7729, 0.0090),
        "GRU": _with_errors(0.1638, 0.0092, 0.2453, 0.0026, 0.7830, 0.0037),
        "MAPPO": _with_errors(0.1635, 0.0067, 0.2808, 0.0037, 0.7858, 0.0050),
        "DP": _with_errors(0.2563, 0.0152, 0.4589, 0.0177, 0.7854, 0.0041),
        "DP/BASS": _with_errors(0.3010, 0.0223, 0.5197, 0.0361, 0.8099, 0.0179),
    },
    # "Results of Different Methods with BASS", Challenge 2
    ("tab:full_results_in_t2: Challenge 2", 2): {
        "MLP": _with_errors(0.2557, 0.0413, 0.3602, 0.0315, 0.8175, 0.0261),
        "GRU": _with_errors(0.2582, 0.0509, 0.3935, 0.0428, 0.8487, 0.0183),
        "DP": _with_errors(0.3125, 0.0564, 0.4526, 0.0427, 0.8442, 0.0184),
        "DP/BASS": _with_errors(0.4348, 0.0599, 0.5535, 0.0423, 0.8474, 0.0128),
    },
    # "Study on Action Sampling Times"
    ("tab:sampling_comparison: BASS", 1): {
        "Sample 4x independently": _means(_METRICS, 0.5027, 0.5707, 0.8615),
        "2x2 combination": _means(_METRICS, 0.4522, 0.5261, 0.8462),
        "4x4 combination": _means(_METRICS, 0.5161, 0.5847, 0.8727),
    },
    ("tab:sampling_comparison: BASS", 2): {
        "Sample 4x independently": _means(_METRICS, 0.4348, 0.5535, 0.8474),
        "2x2 combination": _means(_METRICS, 0.4158, 0.5137, 0.8460),
        "4x4 combination": _means(_METRICS, 0.4396, 0.5638, 0.8559),
    },
    # "Effect of Random Partner Actions"
    ("tab:random_partner: BASS", 1): {
        "BASS": _means(_T, 0.5027),
        "BASS (Random partner action)": _means(_T, 0.3966),
        "BASS w/ Oracle Simulator": _means(_T, 0.5421),
    },
    ("tab:random_partner: BASS", 2): {
        "BASS": _means(_T, 0.4348),
        "BASS (Random partner action)": _means(_T, 0.3650),
        "BASS w/ Oracle Simulator": _means(_T, 0.5334),
    },
    # "Ablation Study"
    ("tab:ablation: GRU", 1): {
        "GRU": _means(_TN, 0.3070, 0.3674),
        "+ BASS w/o Simulation": _means(_TN, 0.4117, 0.4396),
        "+ BASS w/o Augmentation": _means(_TN, 0.3531, 0.4047),
        "+ Full BASS": _means(_TN, 0.4120, 0.4454),
    },
    ("tab:ablation: GRU", 2): {
        "GRU": _means(_TN, 0.2582, 0.3935),
        "+ BASS w/o Simulation": _means(_TN, 0.3333, 0.4141),
        "+ BASS w/o Augmentation": _means(_TN, 0.3670, 0.4246),
        "+ Full BASS": _means(_TN, 0.3414, 0.4410),
    },
    ("tab:ablation: DP", 1): {
        "Diffusion Policy (DP)": _means(_TN, 0.3829, 0.4818),
        "+ BASS w/o Simulation": _means(_TN, 0.4028, 0.5114),
        "+ BASS w/o Augmentation": _means(_TN, 0.4741, 0.5561),
        "+ Full BASS": _means(_TN, 0.5027, 0.5707),
    },
    ("tab:ablation: DP", 2): {
        "Diffusion Policy (DP)": _means(_TN, 0.3125, 0.4526),
        "+ BASS w/o Simulation": _means(_TN, 0.3569, 0.4908),
        "+ BASS w/o Augmentation": _means(_TN, 0.4200, 0.5187),
        "+ Full BASS": _means(_TN, 0.4348, 0.5535),
    },
}


def paper_figures(table: str, challenge: int, label: str) -> Figures:
    """The paper's figures of one row; empty where it has none."""
    return PAPER.get((table, challenge), {}).get(label, {})


def paper_tables() -> set[str]:
    """What `paper:` in a grid may name."""
    return {table for table, _ in PAPER}
