"""A training tells how far it is: by a bar on a terminal, by a line a minute in a log."""

import io

from rich.console import Console

from movingout.agents.training.display import LINE_SECONDS, TrainingDisplay


def _shown(terminal: bool, seconds: float) -> str:
    """What is written of 4 updates of so many seconds, the first of 5 having been made before."""
    text, now = io.StringIO(), [0.0]
    console = Console(file=text, force_terminal=terminal, width=100, color_system=None)
    with TrainingDisplay(5, 1, console, clock=lambda: now[0]) as display:
        for update in range(2, 6):
            now[0] += seconds
            display.show(update, lambda: 0.25)
    return text.getvalue()


def test_a_log_gets_a_line_a_minute_and_the_last() -> None:
    assert _shown(False, LINE_SECONDS).splitlines() == [
        "update 2 of 5, loss 0.2500, about 3 min left",
        "update 3 of 5, loss 0.2500, about 2 min left",
        "update 4 of 5, loss 0.2500, about 1 min left",
        "update 5 of 5, loss 0.2500",
    ]
    assert _shown(False, 1.0).splitlines() == ["update 5 of 5, loss 0.2500"]
    assert "about 12.0 h left" in _shown(False, 4 * 3600.0)


def test_a_terminal_gets_a_bar_and_no_lines() -> None:
    shown = _shown(True, LINE_SECONDS)
    assert "5/5" in shown and "update" not in shown
