"""The API of the annotator's page."""

import csv
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from movingout.recordings.annotation.verdicts import verdicts_of
from tests.recordings.annotation.support import waiting_alone
from tests.server.live import ADMIN, Live, serve


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Live]:
    """A server with two recordings in which blue does not come to help."""
    for name in ("first", "second"):
        waiting_alone(tmp_path / "recordings", name)
    with serve(tmp_path) as live:
        yield live


def findings(live: Live) -> list[dict[str, Any]]:
    """All of them, once everything is searched."""
    while True:
        status, answer = live.call("/api/findings", token=ADMIN)
        assert status == 200
        if answer["remaining"] == 0:
            found: list[dict[str, Any]] = answer["findings"]
            return found


@pytest.mark.slow
def test_findings_name_nobody_and_verdicts_are_kept(served: Live, tmp_path: Path) -> None:
    found = findings(served)
    assert sorted(one["recording"] for one in found) == ["first", "second"]
    assert {(one["case"], one["seat"], one["human"]) for one in found} == {("stays_away", 0, False)}
    assert "bass" not in str(found)  # nobody judges a model by its name
    body = {"finding": found[0]["id"], "verdict": "confirmed", "annotator": "Ada", "note": "clearly"}
    assert served.call("/api/findings/verdicts", body, token=ADMIN) == (200, {"saved": True})
    (kept,) = verdicts_of(tmp_path / "recordings")
    assert (kept.finding, kept.verdict, kept.study, kept.note) == (found[0]["id"], "confirmed", "pilot", "clearly")
    mine = served.call("/api/findings/verdicts?annotator=Ada", token=ADMIN)[1]["verdicts"]
    assert mine == {found[0]["id"]: {"verdict": "confirmed", "note": "clearly"}}
    assert served.call("/api/findings/verdicts?annotator=Bo", token=ADMIN)[1] == {"verdicts": {}}  # not led by others
    table = served.call("/api/findings/annotations.csv", token=ADMIN)[1]
    rows = list(csv.DictReader(io.StringIO(table.decode())))
    assert [row["verdict Ada"] for row in rows if row["finding"] == found[0]["id"]] == ["confirmed"]


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ({"finding": "first:keeps:0:0:1"}, (404, "no_finding")),
        ({"verdict": "perhaps"}, (422, "answer")),
        ({"annotator": ""}, (422, "annotator")),
        ({"more": 1}, (422, "bad_request")),
    ],
)
def test_what_is_no_verdict_is_refused_with_its_reason(
    served: Live, tmp_path: Path, changed: dict[str, Any], expected: tuple[int, str]
) -> None:
    body = {"finding": findings(served)[0]["id"], "verdict": "confirmed", "annotator": "Ada"} | changed
    status, answer = served.call("/api/findings/verdicts", body, token=ADMIN)
    assert (status, answer["error"]["code"]) == expected
    assert verdicts_of(tmp_path / "recordings") == []


@pytest.mark.slow
def test_only_the_operator_sees_and_judges(served: Live) -> None:
    for path, body in (
        ("/api/findings", None),
        ("/api/findings/verdicts?annotator=Ada", None),
        ("/api/findings/verdicts", {"finding": "a", "verdict": "confirmed", "annotator": "Ada"}),
        ("/api/findings/annotations.csv", None),
    ):
        assert served.call(path, body)[0] == 401
        assert served.call(path, body, token="wrong")[0] == 403
