"""One hash of the code that plays, which comments, docstrings and layout do not change."""

from pathlib import Path

import pytest

from movingout.agents.inference import policy_agent
from movingout.maps import library
from movingout.matches.execution import lockstep
from movingout.matches.paper import match_store
from movingout.recordings import versions
from movingout.recordings.versions import code_sha256, meaning
from movingout.study.data.versions import code_versions
from movingout.world import physics


def test_comments_docstrings_and_layout_mean_nothing() -> None:
    bare = meaning(b"def f(x):\n    return x")
    assert meaning(b'"""M."""\ndef f(x):\n    """F."""\n    return (x)  # x') == bare
    assert meaning(b"def f(x):\n    return -x") != bare
    assert meaning(b'async def f():\n    """F."""\n    g()') == meaning(b"async def f():\n    g()")


def test_all_code_that_plays_counts_and_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[bytes] = []
    monkeypatch.setattr(versions, "meaning", lambda source: seen.append(source) or "")  # type: ignore[func-returns-value]
    code_sha256.__wrapped__()
    for module in (policy_agent, library, lockstep, physics):
        assert Path(str(module.__file__)).read_bytes() in seen
    assert Path(str(match_store.__file__)).read_bytes() not in seen


def test_a_study_keeps_it_beside_the_hash_of_all_files() -> None:
    assert code_versions()["movingout_code"] == code_sha256() != code_versions()["source_sha256"]
