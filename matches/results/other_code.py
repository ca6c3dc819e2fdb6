"""Whether results were played by one state of the project's code: those of another may differ for that alone.

Files of before have no hash of the code in them: what wrote them was another state, too.
"""

from collections.abc import Iterable
from dataclasses import replace

from movingout.matches.match import MatchResult
from movingout.recordings.versions import code_sha256

MIXED = (
    "The matches were not all played with the same code of this project: between states of it, results may differ for "
    "that alone."
)


def with_code(result: MatchResult) -> MatchResult:
    """The result with the hash of the present code, as it is kept in a file."""
    return replace(result, code=code_sha256())


def of_other_code(results: Iterable[MatchResult]) -> int:
    """How many were played by other code than is here; a state that noted no hash was another one."""
    return sum(result.code != code_sha256() for result in results)


def is_mixed(results: Iterable[MatchResult]) -> bool:
    """Whether some were played by other code than others; of a folder in which none has a hash, nothing is known."""
    return len({result.code for result in results}) > 1


def played_by_other_code(matches: int) -> str:
    """`2 matches here were played with other code of this project; ...`"""
    what = f"{matches:,} match{'es here were' if matches != 1 else ' here was'} played with other code of this project"
    return f"{what}; results may differ for that alone. To play all with the present code, use an empty folder"
