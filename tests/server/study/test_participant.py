"""A participant's way through a study that is really served: nothing before consent, one code, the same place."""

from pathlib import Path

from recordings.index import list_recordings
from study.store.tables import answers, rounds
from tests.server.study.support import served


def test_from_the_link_to_the_code(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        visitor = study.visitor(PROLIFIC_PID="5f3c", STUDY_ID="s1")
        kinds = [visitor.kind]
        while visitor.kind != "code":
            visitor.do()
            kinds.append(visitor.kind)
        assert kinds == [
            "consent", "form", "input-check", "practice", "round", "questionnaire", "round", "questionnaire",
            "debrief", "code",
        ]  # fmt: skip
        code = visitor.step["code"]
        assert visitor.step == {
            "key": "code", "kind": "code", "code": code, "outcome": "done", "kept": True,
            "completion_url": f"https://app.prolific.com/submissions/complete?cc={code}",
            "earned": {"minutes": visitor.step["earned"]["minutes"], "amount": visitor.step["earned"]["amount"],
                       "currency": "USD"},
        }  # fmt: skip
        store = study.running.records.store
        assert [(row["outcome"], row["ticks"]) for row in store.rows(rounds)] == [("time", 20)] * 2
        assert len(store.rows(answers)) == 7 + 2 * 10
    found, damaged = list_recordings(tmp_path / "recordings")
    assert (len(found), damaged) == (2, [])
