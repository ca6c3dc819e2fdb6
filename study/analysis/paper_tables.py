"""The tables that stand beside the paper's human study: its metrics, its test of ratings, failure rates per session."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from movingout.matches.experiment.paper_reference import PAPER_METRICS, paper_figures
from movingout.matches.paper.published import published_tables
from movingout.recordings.annotation.agreement import agreements, by_case
from movingout.recordings.annotation.verdicts import Verdicts
from movingout.recordings.report.failures import CASES, Case
from movingout.recordings.report.words import Words
from movingout.study.analysis.questions import rated_items
from movingout.study.analysis.results import Results, Row
from movingout.study.analysis.sessions import PAPER_FAILURES, PAPER_SESSIONS, Session, by_partner, paper_label
from movingout.study.analysis.tables import ENGLISH, Namer, ReportTable, block_cells, rating_comparisons
from movingout.world.estimates import Estimate, estimate, estimate_text

HUMAN_ROWS = "tab:task_1_results: Play with Human"
RATED, _COMPARED = "fig:human_study_results", {"helpfulness", "physics"}  # items of the paper's questionnaire
CHALLENGES = (1, 2)
OFFICIAL = "waiting_share", "official_ac"  # as the official code counts, from recordings
MEASURED = (*PAPER_METRICS, "official_ac")
THEIRS = (*PAPER_METRICS, "ac")  # of the paper, beside these
HEADS = ("TCR ↑", "NFD ↑", "WT [share] ↓", "AC ↑")


def paper_table(results: Results, name: Namer, words: Words = ENGLISH) -> ReportTable | None:
    """Each partner that the paper also had people play with, by challenge, beside the paper's row.

    None without such a partner, and in a blinded report: the paper's row names the agent. The paper prints no numbers
    of people in Challenge 2.
    """
    if results.blinded:
        return None
    say, blocks, rows = words.say, results.by_condition(), []
    for partner, label in _paper_partners(results).items():
        for where, part in blocks:
            for challenge in CHALLENGES:
                for source in _beside(part, partner, label, challenge, name, words):
                    rows.append((*block_cells(blocks, where), *source))
    if not rows:
        return None
    head = (*block_cells(blocks, say("study.block")), say("study.partner"), say("study.paper.source"))
    heads = (*head, say("study.paper.challenge"), say("study.rounds"), *HEADS, say("study.paper.official-ac"))
    return ReportTable("paper", say("study.paper"), heads, tuple(rows), len(head), say("study.paper.note"))


def _beside(
    results: Results, partner: str, label: str, challenge: int, name: Namer, words: Words
) -> Iterator[tuple[str, ...]]:
    """Our row and the paper's, where there are rounds."""
    played, say = _rounds(results, partner, challenge), words.say
    if played:
        ours = name(partner), say("study.paper.ours"), str(challenge), str(len(played))
        yield (*ours, *(estimate_text(estimate(_values(results, played, key))) for key in MEASURED))
        yield label, say("study.paper.theirs"), str(challenge), "–", *_published(challenge, label)


def _rounds(results: Results, partner: str, challenge: int) -> list[Row]:
    """Those that count, on the maps as designed (1) or on variants of them (2)."""
    return [
        row
        for row in results.rounds
        if row["partner"] == partner and (row["variant_seed"] is not None) == (challenge == 2)
    ]


def _published(challenge: int, label: str) -> list[str]:
    """The paper's row with people, a dash where it has none."""
    figures = paper_figures(HUMAN_ROWS, challenge, label)
    found = [figures.get(metric) for metric in THEIRS]
    return [estimate_text(one and Estimate(one.mean, one.stderr, 0)) for one in found]


def rating_table(results: Results, name: Namer, words: Words = ENGLISH) -> ReportTable:
    """`tables.rating_comparisons`, and what the paper found where people rate its two models as it asked.

    Not in a blinded report: who looks for the paper's result would know which partner is which.
    """
    table = rating_comparisons(results, name, words)
    asked = {one.item.id for one in rated_items(results.study)}
    labels = set(_paper_partners(results).values())
    if results.blinded or not table.rows or not asked >= _COMPARED or len(labels) < len(PAPER_FAILURES):
        return table
    figures = {column.measure: one.text for column, one in published_tables()[RATED].rows[0].figures.items()}
    p = words.decimal(figures["p_value"])
    said = words.say("study.paper.ratings", p=p, participants=figures["participants"])
    return replace(table, note=f"{table.note} {said}")


def failure_table(results: Results, name: Namer, words: Words = ENGLISH) -> ReportTable:
    """By partner and case, in how many sessions it occurs: by rules, confirmed, and in the paper unless blinded."""
    blocks, say, rows = results.by_condition(), words.say, []
    for where, part in blocks:
        found, labels = by_partner(part.sessions.sessions), _paper_partners(part)
        for partner in (one for one in part.partners if one in found):
            papers = None if results.blinded else labels.get(partner, "")
            for case in CASES:
                cells = _failure_cells(found[partner], case, results.sessions.verdicts, papers)
                rows.append((*block_cells(blocks, where), name(partner), say(f"case.{case}"), *cells))
    head = (*block_cells(blocks, say("study.block")), say("study.partner"), say("study.failures.case"))
    heads = (
        *(*head, say("study.failures.sessions")),
        *(say("study.failures.rules"), say("study.failures.confirmed")),
        *([] if results.blinded else [say("study.paper.theirs")]),
    )
    title, note = say("study.failures"), say("study.failures.note", sessions=PAPER_SESSIONS)
    return ReportTable("failures", title, heads, tuple(rows), len(head), note, say("study.failures.empty"))


def _failure_cells(sessions: Sequence[Session], case: Case, verdicts: Verdicts, papers: str | None) -> tuple[str, ...]:
    """How many sessions, in how many of them, confirmed in how many, and the paper's share for its label `papers`."""
    hits = sum(session.has(case) for session in sessions)
    sure = sum(session.confirmed(case, verdicts) for session in sessions)
    confirmed = _share(sure, len(sessions)) if verdicts else "–"
    ours = str(len(sessions)), _share(hits, len(sessions)), confirmed
    return ours if papers is None else (*ours, _papers(papers, case))


def annotation_table(results: Results, words: Words = ENGLISH) -> ReportTable:
    """What annotators made of the findings of each case."""
    say = words.say
    rows = tuple(
        (
            *(say(f"case.{one.case}"), str(one.findings), str(one.judged), str(one.confirmed), str(one.rejected)),
            *(str(one.disputed), "–" if one.precision is None else f"{one.precision:.3f}"),
        )
        for one in by_case(results.sessions.findings, results.sessions.verdicts)
    )
    columns = ("case", "findings", "judged", "confirmed", "rejected", "disputed", "precision")
    heads = tuple(say(f"study.failures.{column}") for column in columns)
    return ReportTable("annotations", say("study.annotations"), heads, rows, 1, say("study.annotations.note"))


def agreement_table(results: Results, words: Words = ENGLISH) -> ReportTable:
    """Every pair of annotators who were sure about the same findings."""
    say = words.say
    rows = tuple(
        (
            *(f"{one.one} – {one.other}", str(one.both), f"{one.same / one.both:.3f}"),
            "–" if one.kappa is None else f"{one.kappa:.3f}",
        )
        for one in agreements(results.sessions.findings, results.sessions.verdicts)
    )
    heads = tuple(say(f"study.agreement.{column}") for column in ("pair", "both", "same", "kappa"))
    empty = say("study.agreement.empty")
    return ReportTable("agreement", say("study.agreement"), heads, rows, 1, say("study.agreement.note"), empty)


def _paper_partners(results: Results) -> dict[str, str]:
    """Partner to the paper's label, of those that the paper has."""
    agents = {one.id: one.agent for one in results.study.partners}
    labels = {partner: paper_label(agents.get(partner, "")) for partner in results.partners}
    return {partner: label for partner, label in labels.items() if label}


def _values(results: Results, played: Sequence[Row], metric: str) -> list[float]:
    """A metric of every round that has it; what the official code counts is known where there is a recording."""
    if metric not in OFFICIAL:
        return [row[metric] for row in played if row[metric] is not None]
    values = results.sessions.official(metric)
    return [values[row["episode"]] for row in played if row["episode"] in values]


def _share(part: int, all_: int) -> str:
    return f"{part} / {all_} ({part / all_:.3f})"


def _papers(label: str, case: Case) -> str:
    """The share with the paper's own digits, and of how many sessions it is."""
    if not label:
        return "–"
    share = PAPER_FAILURES[label][case]
    return f"{round(PAPER_SESSIONS * share.mean)} / {PAPER_SESSIONS} ({share.text})"
