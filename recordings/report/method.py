"""The rules by which failure cases are found, in words."""

from movingout.recordings.report import failures as cases
from movingout.recordings.report.failures import Case
from movingout.world.constants import TICK_SECONDS


def rules() -> dict[Case, str]:
    """What counts as each failure case, with the thresholds that `failures` uses."""
    return {
        "keeps": (
            f"For at least {cases.KEEPS_TICKS * TICK_SECONDS:g} s a seat holds a small item while its partner has a "
            f"free hand (or a hand on that item), is nearer to the goal than the item, and is within "
            f"{cases.KEEPS_REACH:.2f} of it or touches the holder; and the item comes less than "
            f"{cases.KEEPS_PROGRESS:g} nearer to the goal in any second of that."
        ),
        "stays_away": (
            f"A seat alone holds a middle or large item, and over {cases.HELP_TICKS * TICK_SECONDS:g} s its partner "
            f"comes less than {cases.HELP_APPROACH:g} nearer to it and is not there already."
        ),
        "no_grasp": (
            f"For at least {cases.GRASP_TICKS * TICK_SECONDS:g} s a seat with an empty hand has an undelivered item "
            f"within {cases.GRASP_NEAR:g} of the point from which it grasps, having come there or trying to grasp."
        ),
    }
