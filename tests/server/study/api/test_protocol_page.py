"""What docs/protocol.md says of a study, against the server: whoever writes a page of their own reads nothing else."""

import re
from unittest.mock import MagicMock

from fastapi.routing import APIRoute

from movingout.server.study.api import experimenter, participant
from tests.server.study.support import Served
from tests.support import ROOT

PAGE = (ROOT / "docs" / "protocol.md").read_text(encoding="utf-8")
OF_STUDIES = PAGE.partition("\n## Studies")[2]
OLD_NAMES = {"next-code"}  # of open-next


def test_it_names_all_that_a_page_learns_of_the_study(solo: Served) -> None:
    (row,) = re.findall(r"^\| `GET` \|.*$", OF_STUDIES, re.MULTILINE)
    assert {field for field in solo.live.call("/api/study")[1] if f"`{field}`" not in row} == set()


def test_it_names_every_code_that_refuses_a_participant() -> None:
    codes = {
        code
        for path in (ROOT / "server" / "study").rglob("*.py")
        for code in re.findall(r'(?:ArrivalRefused|StepRefused|ApiError)\((?:\d+, )?"(\w+)"', path.read_text("utf-8"))
    }
    assert len(codes) > 15
    assert {code for code in codes if f"`{code}`" not in OF_STUDIES} == set()


def test_it_names_every_address_of_a_study() -> None:
    routers = (experimenter.routes(*[MagicMock()] * 3), participant.routes(*[MagicMock()] * 3))
    routes = [route for router in routers for route in router.routes]
    names = {route.path.rpartition("/")[2] for route in routes if isinstance(route, APIRoute)} - OLD_NAMES
    assert len(names) > 15
    assert {name for name in names if not re.search(rf"/{re.escape(name)}\b", OF_STUDIES)} == set()
