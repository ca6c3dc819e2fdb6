"""How far annotators agree with the rules and with each other."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations

from movingout.recordings.annotation.finding import Finding
from movingout.recordings.annotation.verdicts import VerdictLine, Verdicts
from movingout.recordings.report.failures import CASES, Case


@dataclass(frozen=True, slots=True)
class CaseAnnotation:
    """What became of the findings of one case."""

    case: Case
    findings: int
    judged: int  # by at least one annotator who was not unsure
    confirmed: int  # by more annotators than rejected it
    rejected: int
    disputed: int  # as many confirm it as reject it

    @property
    def precision(self) -> float | None:
        """The share of settled findings that people confirm; None where nothing is settled."""
        settled = self.confirmed + self.rejected
        return self.confirmed / settled if settled else None


@dataclass(frozen=True, slots=True)
class Agreement:
    """Two annotators over the findings on which both were sure."""

    one: str
    other: str
    both: int
    same: int
    kappa: float | None  # Cohen's; None where chance alone would make them agree always


def settled(lines: Iterable[VerdictLine]) -> bool | None:
    """Whether more annotators confirm a finding than reject it; None when nobody is sure, or as many do either."""
    counts = Counter(line.verdict for line in lines)
    if counts["confirmed"] == counts["rejected"]:
        return None
    return counts["confirmed"] > counts["rejected"]


def by_case(findings: Sequence[Finding], verdicts: Verdicts) -> list[CaseAnnotation]:
    """A row per case of the paper."""
    rows = []
    for case in CASES:
        said = [list(verdicts.get(one.id, {}).values()) for one in findings if one.case == case]
        sure = [any(line.verdict != "unsure" for line in lines) for lines in said]
        outcomes = Counter(settled(lines) for lines in said)
        judged = sum(sure)
        rows.append(
            CaseAnnotation(
                case=case,
                findings=len(said),
                judged=judged,
                confirmed=outcomes[True],
                rejected=outcomes[False],
                disputed=judged - outcomes[True] - outcomes[False],
            )
        )
    return rows


def agreements(findings: Iterable[Finding], verdicts: Verdicts) -> list[Agreement]:
    """Every pair of annotators who judged a common finding."""
    ids = {one.id for one in findings}
    said = {finding: lines for finding, lines in verdicts.items() if finding in ids}
    names = sorted({name for lines in said.values() for name in lines})
    found = []
    for one, other in combinations(names, 2):
        pairs = [
            (lines[one].verdict == "confirmed", lines[other].verdict == "confirmed")
            for lines in said.values()
            if one in lines and other in lines and "unsure" not in (lines[one].verdict, lines[other].verdict)
        ]
        if pairs:
            found.append(Agreement(one, other, len(pairs), sum(a == b for a, b in pairs), cohens_kappa(pairs)))
    return found


def cohens_kappa(pairs: Sequence[tuple[bool, bool]]) -> float | None:
    """Agreement beyond chance of two raters (Cohen 1960); None where chance agreement is 1."""
    n = len(pairs)
    observed = sum(a == b for a, b in pairs) / n
    first, second = (sum(column) / n for column in zip(*pairs, strict=True))
    chance = first * second + (1 - first) * (1 - second)
    return None if chance == 1.0 else (observed - chance) / (1 - chance)
