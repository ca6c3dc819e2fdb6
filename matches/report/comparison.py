"""Our results beside the paper's, with a caution about what the comparison cannot say."""

from collections import defaultdict
from collections.abc import Sequence
from typing import Any, NamedTuple

from movingout.matches.experiment.paper_reference import PAPER_METRICS, paper_figures
from movingout.matches.grid_run import GridRun
from movingout.matches.match import MatchResult
from movingout.matches.paper.published import Figure
from movingout.matches.report.words import count_words, report_words, value_text
from movingout.matches.results.significance import evidence, stars, welch
from movingout.matches.results.table import (
    MEASURES,
    OFFICIAL_AC,
    WAITING,
    Measure,
    are_of_before,
    distinct,
    estimate_json,
    estimate_of,
    markdown_line,
)
from movingout.matches.results.unanswered import have_uncounted_questions, unanswered
from movingout.recordings.report.words import DEFAULT, Words
from movingout.world.estimates import Estimate

PLAYED = (*MEASURES, WAITING, OFFICIAL_AC)
COMPARED = tuple(next(one for one in PLAYED if one.key == key) for key in (*PAPER_METRICS, "official_ac"))


class ComparisonLine(NamedTuple):
    """One method in one condition, all maps and partners together."""

    condition: str
    challenge: int
    label: str
    results: tuple[MatchResult, ...]
    table: str  # of the paper, empty for none
    against: "tuple[MatchResult, ...] | None"
    against_table: str  # of the paper, of the condition that this one is against

    def ours(self, measure: Measure) -> Estimate | None:
        return estimate_of(self.results, measure)

    def theirs(self, measure: Measure) -> Figure | None:
        return paper_figures(self.table, self.challenge, self.label).get(_of_paper(measure))

    def change(self, measure: Measure) -> tuple[float | None, float | None]:
        """Our change in % from the condition compared with, and Welch's p; None where there is none."""
        if self.against is None:
            return None, None
        p = welch(evidence(self.against, measure), evidence(self.results, measure))
        return _percent(estimate_of(self.against, measure), self.ours(measure)), p

    def their_change(self, measure: Measure) -> float | None:
        """The paper's change in %, from its means."""
        before = paper_figures(self.against_table, self.challenge, self.label).get(_of_paper(measure))
        now = self.theirs(measure)
        return _percent(before, now)


def _of_paper(measure: Measure) -> str:
    """The paper's metric beside one of ours: its AC beside both, by its formula and as its code counts."""
    return "ac" if measure is OFFICIAL_AC else measure.key


def _percent(before: Estimate | Figure | None, now: Estimate | Figure | None) -> float | None:
    """The change of the mean in %; None where there is none, and from zero or less, where it would say the opposite."""
    if before is None or now is None or before.mean <= 0.0:
        return None
    return 100.0 * (now.mean - before.mean) / before.mean


def comparison_lines(run: GridRun) -> list[ComparisonLine]:
    """One line per condition, challenge and label, in the order of the grid."""
    pooled: dict[tuple[str, int, str], dict[str, MatchResult]] = defaultdict(dict)
    for entry in run.plan:
        result = run.results.get(entry.match)
        if result is not None:
            pooled[entry.condition, entry.match.challenge, entry.agent][result.match.id] = result
    found = {key: tuple(results.values()) for key, results in pooled.items()}
    papers = {condition.name: condition.paper for condition in run.grid.all_conditions}
    against = {condition.name: condition.against for condition in run.grid.all_conditions}
    return [
        ComparisonLine(name, challenge, label, results, papers[name],
             found.get((against[name], challenge, label)), papers.get(against[name], ""))
        for (name, challenge, label), results in sorted(found.items(), key=lambda item: item[0][1])
    ]  # fmt: skip


def markdown_report(runs: Sequence[GridRun], language: str = DEFAULT) -> str:
    """The report of several grids."""
    words = report_words(language)
    parts = [f"# {words.say('paper.title')}", words.say("paper.caution")]
    for run in runs:
        table = _table(comparison_lines(run), words)
        parts += [f"## {run.grid.name}", run.grid.about.strip(), table, _notes(run, words)]
    return "\n\n".join(part for part in parts if part) + "\n"


def json_report(runs: Sequence[GridRun]) -> dict[str, Any]:
    """The same as one JSON document, in English."""
    return {"caution": report_words().say("paper.caution"), "grids": [_grid_json(run) for run in runs]}


def _table(lines: Sequence[ComparisonLine], words: Words) -> str:
    heads = [*(words.say(f"grid.{key}") for key in ("condition", "challenge", "agent")), "n"]
    for measure in COMPARED:
        heading = words.say("paper.official-ac") if measure is OFFICIAL_AC else measure.heading
        heads += [words.say("paper.here", measure=heading), words.say("paper.paper")]
    rows = [heads, ["---"] * 3 + ["--:"] * (len(heads) - 3)]
    for line in lines:
        row = [line.condition, str(line.challenge), line.label, count_words(words, line.results)]
        for measure in COMPARED:
            ours, theirs = value_text(words, line.ours(measure)), _figure_words(line.theirs(measure))
            if line.against is not None and line.ours(measure) is not None:
                ours += words.decimal(_change_words(*line.change(measure)))
            if (change := line.their_change(measure)) is not None:
                theirs += _change_words(change, None)
            row += [ours, words.decimal(theirs)]
        rows.append(row)
    tables = sorted({line.table for line in lines if line.table})
    source = words.say("paper.tables", tables=tables) if tables else words.say("paper.none")
    return "\n".join(map(markdown_line, rows)) + f"\n\n{source}"


def _change_words(percent: float | None, p: float | None) -> str:
    return f" ({'–' if percent is None else f'{percent:+.1f} %'}{stars(p)})"


def _figure_words(figure: Figure | None) -> str:
    if figure is None:
        return ""
    return figure.text + (f" ± {figure.error_text}" if figure.error_text else "")


def _notes(run: GridRun, words: Words) -> str:
    notes = [words.say("paper.note")]
    if any(distinct(line.results) not in (None, len(line.results)) for line in comparison_lines(run)):
        notes.append(words.say("grid.copies"))
    if found := unanswered(run.results.values()):
        notes.append(words.say("grid.unanswered", **found._asdict()))
    if have_uncounted_questions(run.results.values()):
        notes.append(words.say("grid.uncounted"))
    if are_of_before(run.results.values()):
        notes.append(words.say("grid.earlier"))
    if run.mixed_code:
        notes.append(f"**{words.say('grid.mixed-code')}**")
    if run.missing:
        notes.append(f"**{words.say('grid.missing', count=run.missing)}**")
    if run.failures:
        notes.append(words.say("grid.failures", count=len(run.failures), example=run.failures[0].failure))
    return " ".join(notes)


def _grid_json(run: GridRun) -> dict[str, Any]:
    return {
        "grid": run.grid.name,
        "missing": run.missing,
        "failed": len(run.failures),
        "lines": [
            {
                "condition": line.condition,
                "challenge": line.challenge,
                "agent": line.label,
                "paper_table": line.table,
                "distinct": distinct(line.results),
                "ours": {measure.key: estimate_json(line.ours(measure)) for measure in PLAYED},
                "paper": {
                    measure.key: {"mean": figure.mean, "stderr": figure.stderr}
                    for measure in COMPARED
                    if (figure := line.theirs(measure)) is not None
                },
                "change_percent": {measure.key: line.change(measure)[0] for measure in COMPARED},
                "p": {measure.key: line.change(measure)[1] for measure in COMPARED},
            }
            for line in comparison_lines(run)
        ],
    }
