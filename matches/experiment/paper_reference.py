"""The paper's figures, to compare ours with. Copied digit by digit; tables are named by their LaTeX labels.

The paper's agents were trained on people and played with themselves, across groups, or with people. Its waiting times
lie between 0 and 1, so they are not seconds, as its formula would give, but the share of ticks that the official code
counts; ours of that kind stand beside them.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple


class Figure(NamedTuple):
    """A mean and, where the paper gives one, its standard error."""

    mean: float
    stderr: float | None = None


PAPER_METRICS = ("tcr", "nfd", "waiting_share", "ac")
Figures = Mapping[str, Figure]
"""By key of PAPER_METRICS."""


def _with_errors(*numbers: float) -> Figures:
    """tcr, its error, nfd, its error, the share of waiting, its error, ac, its error."""
    pairs = zip(PAPER_METRICS, numbers[::2], numbers[1::2], strict=True)
    return {name: Figure(mean, stderr) for name, mean, stderr in pairs}


def _means(metrics: Sequence[str], *numbers: float) -> Figures:
    return {name: Figure(mean) for name, mean in zip(metrics, numbers, strict=True)}


_T = ("tcr",)

PAPER: Mapping[tuple[str, int], Mapping[str, Figures]] = {
    # "Full Results for Challenge 1 AI-AI Collaboration"
    ("tab:task_1_results: Seen", 1): {
        "MLP": _with_errors(0.2126, 0.0072, 0.2987, 0.0048, 0.4896, 0.0021, 0.8013, 0.0093),
        "GRU": _with_errors(0.2369, 0.0183, 0.3011, 0.0142, 0.4975, 0.0202, 0.8151, 0.0173),
        "MAPPO": _with_errors(0.1929, 0.0038, 0.3182, 0.0045, 0.5766, 0.0068, 0.8097, 0.0071),
        "DP": _with_errors(0.3233, 0.0279, 0.5367, 0.0151, 0.3789, 0.0167, 0.8163, 0.0162),
        "DP/BASS": _with_errors(0.3503, 0.0293, 0.5724, 0.0232, 0.3598, 0.0182, 0.8337, 0.0146),
    },
    ("tab:task_1_results: Unseen", 1): {
        "MLP": _with_errors(0.1433, 0.0061, 0.2413, 0.0033, 0.5647, 0.0031, 0.7729, 0.0090),
        "GRU": _with_errors(0.1638, 0.0092, 0.2453, 0.0026, 0.5758, 0.0065, 0.7830, 0.0037),
        "MAPPO": _with_errors(0.1635, 0.0067, 0.2808, 0.0037, 0.6379, 0.0013, 0.7858, 0.0050),
        "DP": _with_errors(0.2563, 0.0152, 0.4589, 0.0177, 0.4249, 0.0136, 0.7854, 0.0041),
        "DP/BASS": _with_errors(0.3010, 0.0223, 0.5197, 0.0361, 0.3899, 0.0245, 0.8099, 0.0179),
    },
    ("tab:task_1_results: Play with Human", 1): {
        "DP": _with_errors(0.3855, 0.0512, 0.5547, 0.0432, 0.4886, 0.0457, 0.8054, 0.0129),
        "DP/BASS": _with_errors(0.6512, 0.0717, 0.7053, 0.0459, 0.3364, 0.0481, 0.9124, 0.0113),
    },
    # "Results of Different Methods with BASS" (the same means as in tab:ablation)
    ("tab:full_results_in_t1, _t2: MLP", 1): {
        "MLP": _with_errors(0.3568, 0.0508, 0.4118, 0.0338, 0.4380, 0.0419, 0.7890, 0.0250),
        "+ BASS w/o Simulation": _with_errors(0.2952, 0.0436, 0.4207, 0.0359, 0.3639, 0.0358, 0.8060, 0.0126),
    },
    ("tab:full_results_in_t1, _t2: GRU", 1): {
        "GRU": _with_errors(0.3070, 0.0479, 0.3674, 0.0365, 0.3143, 0.0532, 0.7618, 0.0201),
        "+ BASS w/o Simulation": _with_errors(0.4117, 0.0465, 0.4396, 0.0350, 0.3891, 0.0418, 0.8225, 0.0173),
        "+ BASS w/o Augmentation": _with_errors(0.3531, 0.0411, 0.4047, 0.0373, 0.3835, 0.0419, 0.8195, 0.0210),
        "+ Full BASS": _with_errors(0.4120, 0.0513, 0.4454, 0.0392, 0.4218, 0.0426, 0.8345, 0.0173),
    },
    ("tab:full_results_in_t1, _t2: DP", 1): {
        "Diffusion Policy (DP)": _with_errors(0.3829, 0.0681, 0.4818, 0.0514, 0.3075, 0.0374, 0.8395, 0.0216),
        "+ BASS w/o Simulation": _with_errors(0.4028, 0.0666, 0.5114, 0.0493, 0.3392, 0.0428, 0.8242, 0.0254),
        "+ BASS w/o Augmentation": _with_errors(0.4741, 0.0667, 0.5561, 0.0506, 0.3176, 0.0435, 0.8495, 0.0174),
        "+ Full BASS": _with_errors(0.5027, 0.0619, 0.5707, 0.0468, 0.3448, 0.0402, 0.8615, 0.0167),
    },
    ("tab:full_results_in_t1, _t2: MLP", 2): {
        "MLP": _with_errors(0.2557, 0.0413, 0.3602, 0.0315, 0.4867, 0.0418, 0.8175, 0.0261),
        "+ BASS w/o Simulation": _with_errors(0.2014, 0.0336, 0.3656, 0.0244, 0.3657, 0.0332, 0.7890, 0.0250),
    },
    ("tab:full_results_in_t1, _t2: GRU", 2): {
        "GRU": _with_errors(0.2582, 0.0509, 0.3935, 0.0428, 0.4680, 0.0594, 0.8487, 0.0183),
        "+ BASS w/o Simulation": _with_errors(0.3333, 0.0539, 0.4141, 0.0439, 0.5611, 0.0587, 0.8513, 0.0286),
        "+ BASS w/o Augmentation": _with_errors(0.3670, 0.0522, 0.4246, 0.0420, 0.4365, 0.0593, 0.8572, 0.0222),
        "+ Full BASS": _with_errors(0.3414, 0.0522, 0.4410, 0.0442, 0.4379, 0.0596, 0.8754, 0.0165),
    },
    ("tab:full_results_in_t1, _t2: DP", 2): {
        "Diffusion Policy (DP)": _with_errors(0.3125, 0.0564, 0.4526, 0.0427, 0.3100, 0.0385, 0.8442, 0.0184),
        "+ BASS w/o Simulation": _with_errors(0.3569, 0.0547, 0.4908, 0.0385, 0.3256, 0.0431, 0.8373, 0.0147),
        "+ BASS w/o Augmentation": _with_errors(0.4200, 0.0544, 0.5187, 0.0417, 0.3232, 0.0417, 0.8305, 0.0169),
        "+ Full BASS": _with_errors(0.4348, 0.0599, 0.5535, 0.0423, 0.3096, 0.0451, 0.8474, 0.0128),
    },
    ("tab:full_results_in_t2: Challenge 2", 2): {
        "MLP": _with_errors(0.2557, 0.0413, 0.3602, 0.0315, 0.4867, 0.0418, 0.8175, 0.0261),
        "GRU": _with_errors(0.2582, 0.0509, 0.3935, 0.0428, 0.4680, 0.0594, 0.8487, 0.0183),
        "DP": _with_errors(0.3125, 0.0564, 0.4526, 0.0427, 0.3100, 0.0385, 0.8442, 0.0184),
        "DP/BASS": _with_errors(0.4348, 0.0599, 0.5535, 0.0423, 0.3096, 0.0451, 0.8474, 0.0128),
    },
    # "Study on Action Sampling Times"
    ("tab:sampling_comparison: BASS", 1): {
        "Sample 4x independently": _means(PAPER_METRICS, 0.5027, 0.5707, 0.3448, 0.8615),
        "2x2 combination": _means(PAPER_METRICS, 0.4522, 0.5261, 0.3485, 0.8462),
        "4x4 combination": _means(PAPER_METRICS, 0.5161, 0.5847, 0.3390, 0.8727),
    },
    ("tab:sampling_comparison: BASS", 2): {
        "Sample 4x independently": _means(PAPER_METRICS, 0.4348, 0.5535, 0.3096, 0.8474),
        "2x2 combination": _means(PAPER_METRICS, 0.4158, 0.5137, 0.3101, 0.8460),
        "4x4 combination": _means(PAPER_METRICS, 0.4396, 0.5638, 0.3087, 0.8559),
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
}


def paper_figures(table: str, challenge: int, label: str) -> Figures:
    """The paper's figures of one row; empty when it has none."""
    return PAPER.get((table, challenge), {}).get(label, {})


def paper_tables() -> set[str]:
    """What `paper:` in a grid may name."""
    return {table for table, _ in PAPER}
