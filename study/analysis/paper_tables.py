"""The tables that stand beside the paper's human study: its four metrics, and failure rates per session."""

from movingout.matches.experiment.paper_reference import PAPER_METRICS, paper_figures
from movingout.recordings.annotation.agreement import agreements, by_case
from movingout.recordings.report.failures import CASES, Case
from movingout.recordings.report.words import Words
from movingout.study.analysis.results import Results
from movingout.study.analysis.sessions import PAPER_FAILURES, PAPER_SESSIONS, by_partner, paper_label
from movingout.study.analysis.tables import ENGLISH, Namer, ReportTable
from movingout.world.estimates import Estimate, estimate, estimate_text

HUMAN_ROWS = "tab:task_1_results: Play with Human"
HEADS = ("TCR ↑", "NFD ↑", "WT [share] ↓", "AC ↑")


def paper_table(results: Results, name: Namer, words: Words = ENGLISH) -> ReportTable | None:
    """Each partner that the paper also had people play with, beside the paper's row; None without such a partner."""
    rows: list[tuple[str, ...]] = []
    for partner, label in _paper_partners(results).items():
        found = [estimate(_values(results, metric, partner)) for metric in PAPER_METRICS]
        number = len(results.values("tcr", partner))
        rows.append((name(partner), words.say("study.paper.ours"), str(number), *map(estimate_text, found)))
        figures = paper_figures(HUMAN_ROWS, 1, label)
        theirs = [Estimate(figures[metric].mean, figures[metric].stderr, 0) for metric in PAPER_METRICS]
        rows.append((label, words.say("study.paper.theirs"), "–", *map(estimate_text, theirs)))
    if not rows:
        return None
    say = words.say
    heads = (say("study.partner"), say("study.paper.source"), say("study.rounds"), *HEADS)
    return ReportTable("paper", say("study.paper"), heads, tuple(rows), 2, say("study.paper.note"))


def failure_table(results: Results, name: Namer, words: Words = ENGLISH) -> ReportTable:
    """Per partner and case, in how many sessions it occurs: by rules, as confirmed, and in the paper."""
    labels, rows = _paper_partners(results), []
    found, verdicts = by_partner(results.sessions.sessions), results.sessions.verdicts
    for partner in (one for one in results.partners if one in found):
        sessions = found[partner]
        for case in CASES:
            hits = sum(session.has(case) for session in sessions)
            sure = sum(session.confirmed(case, verdicts) for session in sessions)
            rows.append(
                (
                    *(name(partner), words.say(f"case.{case}"), str(len(sessions))),
                    *(_share(hits, len(sessions)), _share(sure, len(sessions)) if verdicts else "–"),
                    _papers(labels.get(partner, ""), case),
                )
            )
    say = words.say
    heads = (
        *(say("study.partner"), say("study.failures.case"), say("study.failures.sessions")),
        *(say("study.failures.rules"), say("study.failures.confirmed"), say("study.paper.theirs")),
    )
    title, note = say("study.failures"), say("study.failures.note", sessions=PAPER_SESSIONS)
    return ReportTable("failures", title, heads, tuple(rows), 2, note, say("study.failures.empty"))


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


def _values(results: Results, metric: str, partner: str) -> list[float]:
    """A metric of every round; the share of waiting is known where there is a recording."""
    if metric != "waiting_share":
        return results.values(metric, partner)
    shares = results.sessions.waiting_shares
    return [shares[row["episode"]] for row in results.rounds if row["partner"] == partner and row["episode"] in shares]


def _share(part: int, all_: int) -> str:
    return f"{part} / {all_} ({part / all_:.3f})"


def _papers(label: str, case: Case) -> str:
    return _share(PAPER_FAILURES[label][case], PAPER_SESSIONS) if label else "–"
