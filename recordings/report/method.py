"""The last section of a report: by which rules everything on it was measured."""

from movingout.recordings.report import failures as cases
from movingout.recordings.report.failures import TITLES, Case
from movingout.world.constants import TICK_SECONDS


def method() -> str:
    rules: dict[Case, str] = {
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
    entries = "".join(f"<dt>{TITLES[case]}</dt><dd>{rule}</dd>" for case, rule in rules.items())
    return (
        "<h2>How this was measured</h2>"
        '<div class="card"><dl><dt>TCR, NFD, WT, AC</dt><dd>The paper\'s metrics, from the recorded states: work '
        "delivered (middle and large items count twice), way to the goal covered, seconds in which one alone held a "
        "middle or large item, and agreement of the two pushes along the line between the robots.</dd>"
        "<dt>Means</dt><dd>Over episodes that were delivered or ran out of time; ± is the standard error of the mean "
        "(sample standard deviation / √n).</dd>"
        f"{entries}<dt>Lengths</dt><dd>Arena units; the arena is 2.4 wide, a robot 0.24, and it drives 0.6 a "
        "second.</dd></dl></div>"
    )
