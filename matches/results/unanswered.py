"""Questions to language models that had no usable answer, counted over matches: there, something else played."""

from collections.abc import Iterable
from typing import NamedTuple

from movingout.agents.around_others import acting_id
from movingout.agents.llm.model_id import LLM, QUESTIONS, USEFUL
from movingout.maps.spec import SEAT_COLOURS
from movingout.matches.match import MatchResult

UNANSWERED = (
    "Language models gave no usable answer to {questions} of {asked} questions, in {matches} of {played} matches; "
    "meanwhile what they said last or their fallback was played."
)

UNCOUNTED = (
    "Some matches of language models were played by an earlier version: whether the models answered in them is not "
    "known."
)


class Unanswered(NamedTuple):
    """Questions without a usable answer, all questions, the matches with such, and all with questions."""

    questions: int
    asked: int
    matches: int
    played: int


def unanswered(results: Iterable[MatchResult]) -> Unanswered | None:
    """None where every question had a usable answer. Matches that occur twice count once, failed ones not at all."""
    asked = {one.match: questions for one in results if (questions := _asked(one))[1]}
    lacking = [without for without, _ in asked.values() if without]
    return (
        Unanswered(sum(lacking), sum(all for _, all in asked.values()), len(lacking), len(asked)) if lacking else None
    )


def have_uncounted_questions(results: Iterable[MatchResult]) -> bool:
    """Whether a language model sat in a seat that an earlier version played: it did not count what was answered."""
    return any(one.ending != "failed" and _has_uncounted(one) for one in results)


def _has_uncounted(result: MatchResult) -> bool:
    ids = dict(zip(SEAT_COLOURS, (result.match.blue, result.match.red), strict=True))
    return any(
        acting_id(agent_id).partition(":")[0] == LLM and f"{colour}_{QUESTIONS}" not in result.counts
        for colour, agent_id in ids.items()
    )


def _asked(result: MatchResult) -> tuple[int, int]:
    """(questions without a usable answer, all questions) of both seats."""
    questions, useful = (
        sum(result.counts.get(f"{colour}_{name}", 0) for colour in SEAT_COLOURS) for name in (QUESTIONS, USEFUL)
    )
    return questions - useful, questions
