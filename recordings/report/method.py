"""The rules by which failure cases are found, in words."""

from movingout.recordings.report import failures as cases
from movingout.recordings.report.failures import CASES, Case
from movingout.recordings.report.words import Words
from movingout.world.constants import TICK_SECONDS


def rules(words: Words) -> dict[Case, str]:
    """What counts as each failure case, with the thresholds that `failures` uses."""
    thresholds = {
        "keeps": {
            "seconds": f"{cases.KEEPS_TICKS * TICK_SECONDS:g}",
            "reach": f"{cases.KEEPS_REACH:.2f}",
            "progress": f"{cases.KEEPS_PROGRESS:g}",
        },
        "stays_away": {"seconds": f"{cases.HELP_TICKS * TICK_SECONDS:g}", "approach": f"{cases.HELP_APPROACH:g}"},
        "no_grasp": {"seconds": f"{cases.GRASP_TICKS * TICK_SECONDS:g}", "near": f"{cases.GRASP_NEAR:g}"},
    }
    return {
        case: words.say(f"rule.{case}", **{name: words.decimal(value) for name, value in thresholds[case].items()})
        for case in CASES
    }
