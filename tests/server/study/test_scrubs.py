"""Ids of who did not agree are overwritten: not at each click, never while others wait, and after a kill too."""

from pathlib import Path

import pytest

from movingout.study.errors import StoreError
from movingout.study.store.database import Database
from movingout.study.store.removal import UNDECIDED_S
from tests.server.study.support import Served, served


def watched(study: Served, monkeypatch: pytest.MonkeyPatch, faults: int = 0) -> list[bool]:
    """Of each time that identities are overwritten, whether somebody held a transaction meanwhile."""
    found: list[bool] = []
    really, mine = Database.scrub, study.running.databases.identities.database

    def scrub(database: Database) -> None:
        if database is mine:
            found.append(study.running._lock.locked())
            if len(found) <= faults:
                raise StoreError("a backup reads them")
        really(database)

    monkeypatch.setattr(Database, "scrub", scrub)
    return found


def test_who_declines_costs_no_overwriting_of_the_whole_database_while_others_wait(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with served(tmp_path) as study:
        scrubs, identities = watched(study, monkeypatch), study.running.databases.identities
        for number in range(5):
            study.visitor(PROLIFIC_PID=f"5f3c{number}").decline()
        study.look()
        assert (scrubs, identities.everybody()) == ([], {})
        study.running.participants._scrub_at = 0.0
        study.look()
        study.look()
        assert scrubs == [False], "once for all of them, and in nobody's way"
        study.visitor(PROLIFIC_PID="5f3c9").decline()
    assert scrubs == [False, False], "the last one at the end"


@pytest.mark.slow
def test_a_start_overwrites_identities_only_where_some_were_deleted_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with served(tmp_path) as study:
        scrubs = watched(study, monkeypatch)
        study.running.participants._scrub_at = 0.0
        study.look()
        assert scrubs == []
        study.visitor(PROLIFIC_PID="5f3c1").decline()
        study.running.participants._unscrubbed = False  # as if it were killed: nothing at the end
    for expected in ([False], []):
        with served(tmp_path) as study:
            scrubs = watched(study, monkeypatch)
            study.running.participants._scrub_at = 0.0
            study.look()
            assert scrubs == expected


def test_identities_that_cannot_be_overwritten_now_are_later(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with served(tmp_path) as study:
        scrubs = watched(study, monkeypatch, faults=1)
        study.visitor(PROLIFIC_PID="5f3c1").decline()
        for number in (1, 2, 2):
            study.running.participants._scrub_at = 0.0
            study.look()
            assert len(scrubs) == number
        assert study.alerts().count("database") == 1


def test_ids_of_who_closed_the_page_at_the_consent_are_overwritten_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with served(tmp_path) as study:
        scrubs = watched(study, monkeypatch)
        study.visitor(PROLIFIC_PID="5f3c1")
        study.later(UNDECIDED_S + 1)
        study.running.participants._scrub_at = 0.0
        study.look()
        assert (scrubs, study.running.databases.identities.everybody()) == ([False], {})
