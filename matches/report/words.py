"""What the reports of matches say, by language: languages/<language>.json, beside the texts of all reports."""

from collections.abc import Sequence
from pathlib import Path

from movingout.matches.match import MatchResult
from movingout.matches.results.table import ALL_MAPS, Measure, distinct
from movingout.recordings.report.words import DEFAULT, Words
from movingout.world.estimates import Estimate, estimate_text

LANGUAGE_FILES = Path(__file__).with_name("languages")


def report_words(language: str = DEFAULT) -> Words:
    """The texts of a language."""
    return Words(language, (LANGUAGE_FILES,))


def map_name(words: Words, name: str) -> str:
    """The name of a map, or that it is all of them."""
    return words.say("grid.all_maps") if name == ALL_MAPS else name


def measure_title(words: Words, measure: Measure) -> str:
    """The measure in words; those of other packages have their own title."""
    return words.known(f"measure.{measure.key}", measure.title)


def value_text(words: Words, found: Estimate | None) -> str:
    """0.500 ± 0.100, with the decimal sign of the language."""
    return words.decimal(estimate_text(found))


def count_words(words: Words, results: Sequence[MatchResult]) -> str:
    """How many episodes, and how many of them are distinct where some are copies."""
    number, different = len(results), distinct(results)
    if different in (None, number):
        return str(number)
    return words.say("grid.count.distinct", n=number, distinct=different)
