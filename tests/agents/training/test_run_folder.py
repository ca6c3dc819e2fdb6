"""A training is gone on with as it was begun, or on purpose with something else."""

import dataclasses
import errno
import json
import os
import stat
from pathlib import Path

import pytest

from movingout.agents.errors import DataError
from movingout.agents.kinds.bass import BASS
from movingout.agents.kinds.kind import AgentKind
from movingout.agents.kinds.policy import DP, MLP
from movingout.agents.policies.config import PolicyConfig
from movingout.agents.training.optimisation import Optimisation
from movingout.agents.training.run_folder import CONFIG, LOCK, RESUME, begin, held, learns_from_other, put_back
from movingout.maps.files import file_lock

ABOUT = {"id": "dp@mine", "kind": "dp", "preset": "fast", "seats": "acting", "data_sha256": "a" * 64}
CONFIGURATION = DP.presets["fast"]


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A run that has been begun, and something was learned in it."""
    folder = tmp_path / "dp-mine"
    begin(folder, ABOUT, CONFIGURATION, on_purpose=False)
    (folder / RESUME).touch()
    return folder


def test_a_run_says_what_it_was_begun_with(run: Path) -> None:
    assert json.loads((run / CONFIG).read_text()) == {**ABOUT, **dataclasses.asdict(CONFIGURATION)}


def test_a_longer_training_or_other_play_is_gone_on_with(run: Path) -> None:
    longer = dataclasses.replace(CONFIGURATION, updates=9000, event_weight=4, threads=2, restless=1.0)
    begin(run, {**ABOUT, "preset": "paper"}, longer, on_purpose=False)
    assert json.loads((run / CONFIG).read_text())["updates"] == 9000


def test_bass_that_simulates_in_other_steps_is_gone_on_with(tmp_path: Path) -> None:
    before = dataclasses.replace(BASS.presets["fast"], dynamics="engine")
    begin(tmp_path, ABOUT, before, on_purpose=False)
    (tmp_path / RESUME).touch()
    begin(tmp_path, ABOUT, dataclasses.replace(before, sub_steps=10), on_purpose=False)
    assert json.loads((tmp_path / CONFIG).read_text())["sub_steps"] == 10


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        (
            {"process": "ddim"},
            "started with process flow, not ddim; to continue it, add --process flow, or train that under another --id",
        ),
        ({"grasp": "toggle", "depth": 4}, "depth 3, not 4; to continue it, add --grasp hold --depth 3, or"),
        ({"obs_horizon": 2}, "obs-horizon 1, not 2"),
        ({"layout": "map-v1", "seed": 3}, "layout aware-v1, not map-v1; to"),
    ],
)
@pytest.mark.parametrize("on_purpose", [False, True])
def test_another_network_is_another_agent(
    run: Path, changes: dict[str, object], sentence: str, on_purpose: bool
) -> None:
    other: Optimisation = dataclasses.replace(CONFIGURATION, **changes)  # type: ignore[arg-type]
    with pytest.raises(DataError, match=sentence):
        begin(run, ABOUT, other, on_purpose)


@pytest.mark.parametrize(
    ("kind", "unused"),
    [(MLP, {"process": "ddpm", "train_steps": 100, "dropout": 0.1}), (BASS, {"window_share": 0.5})],
)
def test_what_did_nothing_when_it_was_still_an_option_may_be_another(
    tmp_path: Path, kind: AgentKind[Optimisation], unused: dict[str, object]
) -> None:
    config = kind.presets["fast"]
    begin(tmp_path, ABOUT, dataclasses.replace(config, **unused), on_purpose=False)  # type: ignore[arg-type]
    (tmp_path / RESUME).touch()
    begin(tmp_path, ABOUT, config, on_purpose=False)


@pytest.mark.parametrize(
    ("about", "changes", "sentence"),
    [
        ({"data_sha256": "b" * 64}, {}, "SHA-256 aaaaaaaaaaaa…, not bbbbbbbbbbbb…; choose another --id, or .*go-on"),
        ({"seats": "human"}, {}, "seats acting, not human"),
        ({}, {"seed": 1, "pose_noise": 0.1}, "seed 0, not 1; pose-noise 0.0, not 0.1"),
    ],
)
def test_other_data_and_another_way_to_train_are_gone_on_with_on_purpose_alone(
    run: Path, about: dict[str, str], changes: dict[str, object], sentence: str
) -> None:
    now = {**ABOUT, **about}
    config: Optimisation = dataclasses.replace(CONFIGURATION, **changes)  # type: ignore[arg-type]
    with pytest.raises(DataError, match=sentence):
        begin(run, now, config, on_purpose=False)
    begin(run, now, config, on_purpose=True)
    begin(run, now, config, on_purpose=False)


RESPONSE = {**ABOUT, "base": "dp@any", "map": "HandOff", "split": "None", "partners": "['idle']", "ticks": "500"}


@pytest.mark.parametrize(
    ("about", "sentence"),
    [
        ({"map": "FourCorners"}, "map HandOff, not FourCorners; choose another --id, or .*go-on"),
        ({"split": "official"}, "split none, not official"),
        ({"partners": "['idle', 'family:greedy']"}, "partners idle, not idle family:greedy"),
        ({"ticks": "200"}, "ticks 500, not 200"),
    ],
)
def test_other_maps_and_partners_are_gone_on_with_on_purpose_alone(
    run: Path, about: dict[str, str], sentence: str
) -> None:
    begin(run, RESPONSE, CONFIGURATION, on_purpose=False)
    with pytest.raises(DataError, match=sentence):
        begin(run, {**RESPONSE, **about}, CONFIGURATION, on_purpose=False)
    before = begin(run, {**RESPONSE, **about}, CONFIGURATION, on_purpose=True)
    assert learns_from_other(run, before)
    put_back(run, before)
    assert not learns_from_other(run, begin(run, RESPONSE, CONFIGURATION, on_purpose=False))


@pytest.mark.parametrize("on_purpose", [False, True])
def test_where_weights_started_is_settled_and_their_base_where_the_kind_says_so(run: Path, on_purpose: bool) -> None:
    begin(run, {**RESPONSE, "start": ""}, CONFIGURATION, on_purpose)
    with pytest.raises(DataError, match="start none, not dp@other; to continue it, add --start '', or train that"):
        begin(run, {**RESPONSE, "start": "dp@other"}, CONFIGURATION, on_purpose)
    other = {**RESPONSE, "base": "dp@other"}
    with pytest.raises(DataError, match="base dp@any, not dp@other; to continue it, add --base dp@any, or train"):
        begin(run, other, CONFIGURATION, on_purpose, {"base": "never"})
    begin(run, other, CONFIGURATION, on_purpose)


def test_what_another_agent_has_begun_is_not_gone_on_with(run: Path) -> None:
    with pytest.raises(DataError, match="kind dp, not mlp; train that under another --id"):
        begin(run, {**ABOUT, "kind": "mlp"}, CONFIGURATION, on_purpose=True)


def test_where_nothing_was_learned_yet_anything_can_begin(run: Path) -> None:
    (run / RESUME).unlink()
    begin(run, {**ABOUT, "data_sha256": "b" * 64}, PolicyConfig(width=8), on_purpose=False)


def test_older_runs_that_do_not_say_it_are_gone_on_with_and_say_it_from_then_on(run: Path) -> None:
    for older in (None, {"kind": "dp", **dataclasses.asdict(CONFIGURATION)}):
        (run / CONFIG).write_text(json.dumps(older)) if older else (run / CONFIG).unlink()
        begin(run, ABOUT, CONFIGURATION, on_purpose=False)
        assert json.loads((run / CONFIG).read_text())["data_sha256"] == "a" * 64


def test_a_folder_is_held_by_one_process_at_a_time(tmp_path: Path) -> None:
    folder = tmp_path / "runs" / "dp-mine"
    refused = pytest.raises(DataError, match=r"another process trains in .*dp-mine; wait until")
    with held(folder), refused, held(folder):
        pass
    with held(folder):
        pass
    (tmp_path / "file").touch()
    with pytest.raises(DataError, match=r"cannot write .*file/dp-mine"), held(tmp_path / "file" / "dp-mine"):
        pass


@pytest.mark.parametrize("code", [errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP, errno.EIO])
def test_where_a_file_system_has_no_locks_nobody_is_kept_out(
    tmp_path: Path, code: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    def without_locks(_descriptor: int, blocking: bool) -> bool:
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(file_lock, "lock_descriptor", without_locks)
    if code == errno.EIO:
        with pytest.raises(DataError, match=r"cannot lock .*dp-mine: Input/output error"), held(tmp_path / "dp-mine"):
            pass
        return
    with held(tmp_path / "dp-mine"), held(tmp_path / "dp-mine"):
        pass


def test_a_group_that_shares_a_folder_shares_its_lock(tmp_path: Path) -> None:
    before = os.umask(0o002)
    try:
        with held(tmp_path):
            pass
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / LOCK).stat().st_mode) == 0o664


def test_a_damaged_file_is_answered_with_a_sentence(run: Path) -> None:
    (run / CONFIG).write_text("{")
    with pytest.raises(DataError, match="does not say what the run was started with"):
        begin(run, ABOUT, CONFIGURATION, on_purpose=False)


@pytest.mark.parametrize("lacks", [("rigid", "grasping"), ("grasping",)])
def test_a_simulator_older_than_a_field_is_not_gone_on_with_as_another_one(
    tmp_path: Path, lacks: tuple[str, ...]
) -> None:
    now = BASS.presets["fast"]
    written = {**ABOUT, **dataclasses.asdict(now), "rigid": False, "order": "joint"}
    (tmp_path / CONFIG).write_text(json.dumps({name: value for name, value in written.items() if name not in lacks}))
    (tmp_path / RESUME).touch()
    with pytest.raises(DataError, match=r"rigid no, not yes; grasping no, .* add --rigid no --grasping no, or train"):
        begin(tmp_path, ABOUT, now, on_purpose=True)
    with pytest.raises(DataError, match="grasping no, not yes"):
        begin(tmp_path, ABOUT, dataclasses.replace(now, rigid=False), on_purpose=True)
    begin(tmp_path, ABOUT, dataclasses.replace(now, rigid=False, grasping=False), on_purpose=False)
    assert json.loads((tmp_path / CONFIG).read_text())["grasping"] is False


def test_a_run_older_than_the_option_started_from_no_agent(run: Path) -> None:
    with pytest.raises(DataError, match="start none, not dp@other"):
        begin(run, {**ABOUT, "start": "dp@other"}, CONFIGURATION, on_purpose=True)
    begin(run, {**ABOUT, "start": ""}, CONFIGURATION, on_purpose=False)
