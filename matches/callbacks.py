"""What a run of matches calls while it goes on, and what it says before it begins."""

import warnings
from collections.abc import Callable
from pathlib import Path

from movingout.matches.execution.dispatch import WorkerPool
from movingout.matches.match import MatchResult

OnProgress = Callable[[int, int], None]
"""Called with the number of finished matches and of all."""
OnAgain = Callable[[int], None]
"""Called with the number of matches that failed before and are played again."""
OnUnrecorded = Callable[[int], None]
"""Called with the number of matches that are to be recorded and were played before without a recording."""
OnOtherCode = Callable[[int], None]
"""Called with the number of matches that are kept and were played by other code of this project than is here."""
OnCaution = Callable[[str], None]
"""Called, before anything is played, with each sentence about a map file that cannot be played as it should, or about
a language model that does not wait."""
OnResult = Callable[[MatchResult], None]
"""Called with each result as it arrives."""
WorkerPoolFactory = Callable[[int, float, Path | None], WorkerPool]
"""Called with (workers, agent_limit_s, record); returns the pool."""


def no_op(*_: object) -> None:
    """Shows no progress and does nothing with a result."""


def warn_caller(sentence: str) -> None:
    """Warn who called the function that says the sentence."""
    warnings.warn(sentence, stacklevel=3)
