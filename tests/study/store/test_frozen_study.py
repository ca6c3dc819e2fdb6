"""A study that has begun is run with the same file, models and kind of participants to its end."""

from pathlib import Path

import pytest

from movingout.study.errors import StudyError
from movingout.study.store.frozen_study import freeze_study, frozen_study
from movingout.study.store.tables import audit
from tests.study.support import TEXT, open_store


def test_a_study_that_has_begun_keeps_its_file_and_its_models(place: Path | str) -> None:
    store = open_store(place)
    open_store(place, text=TEXT + "# before anybody came\n").close()
    store.arrive("P1", "en")
    with pytest.raises(StudyError, match="study agent-survey has begun, and its file has changed since"):
        open_store(place, text=TEXT)
    with pytest.raises(StudyError, match="a model has changed since"):
        freeze_study(store, "agent-survey", TEXT + "# before anybody came\n", {}, {"scripted": "ab"})
    freeze_study(store, "agent-survey", TEXT + "# before anybody came\n", {"movingout": "mended"}, {"scripted": ""})
    assert frozen_study(store).code == {"movingout": "mended"}
    assert [row["action"] for row in store.rows(audit)] == ["freeze", "freeze", "arrive", "code"]


def test_what_simulated_participants_did_is_never_mixed_with_what_people_did(place: Path | str) -> None:
    store = open_store(place)
    freeze_study(store, "agent-survey", TEXT, {}, {"scripted": ""}, simulated=True)
    assert frozen_study(store).simulated
    store.arrive("P1", "en")
    with pytest.raises(StudyError, match=r"holds what simulated participants did, and people .*--rehearse 1"):
        freeze_study(store, "agent-survey", TEXT, {}, {"scripted": ""})
