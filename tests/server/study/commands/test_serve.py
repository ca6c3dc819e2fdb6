"""`movingout study serve`: what it prints, and what it refuses in a sentence."""

import json
import re
import threading
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest

from movingout.server.cli import main
from movingout.server.settings import Settings
from movingout.server.study.commands import partner_timing, serve
from movingout.server.study.commands.partner_timing import THREAD
from movingout.server.study.commands.serve import text_to_freeze
from movingout.study.commands.data import as_frozen
from movingout.study.data.study_folder import StudyFolder
from movingout.study.data.versions import model_hashes
from movingout.study.design import partner_speed
from movingout.study.design.study_file import complete_text, read_study
from movingout.study.store.clock import now_ms
from movingout.study.store.frozen_study import freeze_study
from movingout.study.store.tables import study as study_table
from tests.server.persistence.test_room_snapshot import free_port
from tests.server.study.study_process import study_process
from tests.server.study.support import SOLO
from tests.study.design.small_study import SMALL
from tests.study.design.test_allocation_rules import BLOCK, HEAD, TWICE
from tests.study.design.test_maps_met import write_study
from tests.study.filled import fill
from tests.study.support import agree

pytestmark = pytest.mark.slow

WITH_FILE = re.sub(r'en: "# Consent.*?"', "en: {file: consent.md}", SOLO)


def refused(capsys: pytest.CaptureFixture[str], file: Path, data: Path, *options: str) -> str:
    """What `study serve` says instead of serving."""
    assert main(["study", "serve", str(file), "--data", str(data), *(options or ("--port", "0"))]) == 2
    return capsys.readouterr().err


def test_links_are_printed_and_what_cannot_work_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, port = tmp_path / "study.yaml", free_port()
    file.write_text(SOLO, encoding="utf-8")
    with study_process(file, tmp_path, port, "--codes") as running:
        found = re.search(r"First code\s+(\w+)", running.printed)
        assert found and f"http://127.0.0.1:{port}/study" in running.printed
        assert f"http://127.0.0.1:{port}/experimenter" in running.printed
        status, seen = running.live.call("/api/study/arrive", {"parameters": {"code": found[1]}})
        assert status == 200
        said = {"key": seen["view"]["step"]["key"], "boxes": ["adult"]}
        assert running.live.call("/api/study/next", said, seen["token"])[0] == 200
        assert re.search(r"Token\s+in .+admin-token", running.printed), "only a terminal shows the token itself"
        assert running.live.call("/api/experimenter/state", token=running.token)[0] == 200
        assert "in use by another server" in refused(capsys, file, tmp_path)
        in_use = refused(capsys, file, tmp_path / "other", "--port", str(port))
        assert f"port {port} is in use already" in in_use
    file.write_text(SOLO.replace("id: solo", "id: solo\nseed: 9"), encoding="utf-8")
    assert "study solo has begun, and its file or a text beside it has changed since" in refused(capsys, file, tmp_path)
    file.write_text(SOLO, encoding="utf-8")
    simulated = refused(capsys, file, tmp_path, "--rehearse", "2")
    assert "holds what people did, and simulated participants must not be mixed with them" in simulated


def test_what_the_rule_of_a_begun_study_confounds_is_said_at_the_start(tmp_path: Path) -> None:
    file, port = tmp_path / "study.yaml", free_port()
    file.write_text(HEAD + "".join(BLOCK % (number, *block) for number, block in enumerate(TWICE)), encoding="utf-8")
    study = read_study(file)
    _, store, _ = fill(tmp_path, study, file.read_text(encoding="utf-8"), 1, clock=now_ms)
    with store.database.write() as connection:
        connection.execute(study_table.update().values(allocation=1))
    store.close()
    with study_process(file, tmp_path, port) as running:
        assert running.process.stdout is not None
        printed = [running.process.stdout.readline() for _ in range(2)]
        assert printed[1].startswith("warning: block block-1: role and model are confounded")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("agent: idle}, {id: bad", "agent: nobody}, {id: bad"), "nobody"),
        (("participants: 400", "participants: many"), "study.yaml:6: participants"),
        (("format: 1", "format: ["), "study.yaml:"),
        (
            ("We record **how** you play.", "Ask [name of the investigator]."),
            "the consent has a blank to fill in: [name of the investigator]\nparticipants would read this",
        ),
    ],
)
def test_a_study_that_cannot_run_is_not_served(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], change: tuple[str, str], said: str
) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(SOLO.replace(*change), encoding="utf-8")
    assert said in refused(capsys, file, tmp_path)


def test_a_partner_that_is_too_slow_here_is_refused_before_the_study_begins_and_warned_of_later(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    timed: list[str] = []
    serves, ready = threading.Event(), threading.Event()
    ready.set()

    def decision_ms(agent_id: str, the_map: str) -> float:
        timed.append("while it is served" if serves.is_set() and ready.wait(10.0) else "before")
        return 180.0

    class Server:
        started = True

        def __init__(self, *_: Any, on_ready: Callable[[], None]) -> None:
            self._on_ready = on_ready

        def run(self, _: Any) -> None:
            serves.set()
            ready.clear()
            self._on_ready()
            ready.set()
            for thread in [each for each in threading.enumerate() if each.name == THREAD]:
                thread.join()

    monkeypatch.setattr(partner_speed, "decision_ms", decision_ms)
    file, data = tmp_path / "study.yaml", tmp_path / "data"
    file.write_text(SOLO, encoding="utf-8")
    said = refused(capsys, file, data)
    assert said.startswith("movingout: idle needs 180 ms for a decision on HandOff on this machine") and timed
    study = read_study(file)
    serve._refuse_slow(study, Settings(slow_agents=True))
    with closing(StudyFolder(study, data).open()) as store, closing(StudyFolder(study, data).open_identities()):
        freeze_study(store, "solo", complete_text(file), {}, model_hashes(study))
        agree(store, ["P1"])
    timed.clear()
    assert "must not be mixed" in refused(capsys, file, data, "--rehearse", "2")
    assert not timed
    monkeypatch.setattr(serve, "game_server", Server)
    for options, warnings in (((), 2), (("--slow-agents",), 0)):
        assert main(["study", "serve", str(file), "--data", str(data), "--port", "0", *options]) == 0
        warned = [line for line in capsys.readouterr().err.splitlines() if partner_timing.__name__ in line]
        assert len(warned) == warnings == len(timed) * 2
        assert not warned or ("idle needs 180 ms" in warned[0] and "stands still" in warned[1])
        assert timed == ["while it is served"] * (warnings // 2), "nobody waits for it"
        timed.clear()


@pytest.mark.parametrize(
    ("agent", "said"),
    [("bass@any", "cannot play maps/five.json"), ("scripted:patience=40,patience=60", "patience stands twice")],
)
def test_agents_that_keep_a_study_from_beginning_are_a_warning_in_one_that_has_begun(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, agent: str, said: str
) -> None:
    file, data = write_study(tmp_path, SMALL.replace("agent: scripted", f"agent: '{agent}'")), tmp_path / "data"
    assert said in refused(capsys, file, data)
    folder = StudyFolder(read_study(file), data)
    with closing(folder.open()) as store, closing(folder.open_identities()):
        freeze_study(store, folder.study.id, complete_text(file), {}, model_hashes(folder.study))
        agree(store, ["P1"])
    monkeypatch.setattr(serve, "game_server", lambda *_, **__: Mock(started=True))
    assert main(["study", "serve", str(file), "--data", str(data), "--port", "0"]) == 0
    warned = [line for line in capsys.readouterr().err.splitlines() if line.startswith("warning: ")]
    assert len(warned) == 1 and said in warned[0]
    checked = ["study", "check", str(file), "--json", "--data"]
    assert main([*checked, str(tmp_path / "elsewhere")]) == 1
    assert [*map(str, json.loads(capsys.readouterr().out)["missing"])] == [warned[0].removeprefix("warning: ")]
    main([*checked, str(data)])
    told = json.loads(capsys.readouterr().out)
    assert warned[0].removeprefix("warning: ") in told["warnings"], "in the same words"
    assert not told["missing"] and any("has begun" in sentence for sentence in told["warnings"])
    file.write_text(file.read_text(encoding="utf-8") + "# changed\n", encoding="utf-8")
    main([*checked, str(data)])
    assert json.loads(capsys.readouterr().out)["missing"], "as this file it has not begun"


def test_the_title_of_a_study_does_not_command_the_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    class Server:
        started = True

        def __init__(self, *_: Any, on_ready: Callable[[], None]) -> None:
            self.run = lambda _: on_ready()

    monkeypatch.setattr(partner_speed, "decision_ms", lambda *_: 1.0)
    monkeypatch.setattr(serve, "game_server", Server)
    file = tmp_path / "study.yaml"
    file.write_text(SOLO.replace("{en: StudyRooms with partners,", '{en: "\\e[31mWith partners",'), encoding="utf-8")
    assert main(["study", "serve", str(file), "--data", str(tmp_path / "data"), "--port", "0"]) == 0
    told = capsys.readouterr().out
    assert "[31mWith partners (solo) is being served" in told and "\x1b" not in told


def test_a_study_that_was_served_and_met_nobody_has_not_begun(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(partner_speed, "decision_ms", lambda *_: 180.0)
    monkeypatch.setattr(serve, "game_server", lambda *_, **__: Mock(started=True))
    file, data = tmp_path / "study.yaml", tmp_path / "data"
    file.write_text(SOLO, encoding="utf-8")
    folder = StudyFolder(read_study(file), data)
    with closing(folder.open()) as store, closing(folder.open_identities()):
        freeze_study(store, "solo", complete_text(file), {}, model_hashes(folder.study))
    assert "idle needs 180 ms" in refused(capsys, file, data)
    file.write_text(SOLO.replace("We record **how** you play.", "Ask [name]."), encoding="utf-8")
    assert "the consent has a blank to fill in: [name]" in refused(capsys, file, data)
    file.write_text(SOLO.replace("agent: idle", "agent: 'scripted:patience=40,patience=60'", 1), encoding="utf-8")
    assert "patience stands twice" in refused(capsys, file, data)


@pytest.mark.parametrize("options", [("--rehearse", "0"), ("--rehearse", "1000"), ("--database", "oracle://host/name")])
def test_what_makes_no_sense_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, str]
) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(SOLO, encoding="utf-8")
    said = refused(capsys, file, tmp_path, "--port", "0", *options)
    assert said.startswith("movingout: ") and "Traceback" not in said


def test_a_text_beside_the_file_of_a_study_that_has_begun_may_not_change(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, consent = tmp_path / "study.yaml", tmp_path / "consent.md"
    file.write_text(WITH_FILE, encoding="utf-8")
    consent.write_text("We record how you play.", encoding="utf-8")
    folder = StudyFolder(read_study(file), tmp_path / "data")
    with closing(folder.open()) as store, closing(folder.open_identities()):
        freeze_study(store, "solo", complete_text(file), {}, model_hashes(folder.study))
        agree(store, ["P1"])
    consent.write_text("We record who you are.", encoding="utf-8")
    assert "its file or a text beside it has changed since" in refused(capsys, file, tmp_path / "data")


def test_a_study_that_began_with_an_earlier_version_goes_on(tmp_path: Path) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(WITH_FILE, encoding="utf-8")
    (tmp_path / "consent.md").write_text("We record how you play.", encoding="utf-8")
    assert text_to_freeze(file, WITH_FILE) == WITH_FILE
    assert text_to_freeze(file, None) == complete_text(file) != WITH_FILE


def test_a_study_that_began_with_the_mark_of_notepad_goes_on(tmp_path: Path) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(WITH_FILE, encoding="utf-8")
    (tmp_path / "consent.md").write_text("# Consent", encoding="utf-8-sig")
    begun_with = complete_text(file).replace('"# Consent', '"\\U0000feff# Consent')
    assert text_to_freeze(file, begun_with) == begun_with != complete_text(file)
    (tmp_path / "consent.md").write_text("# Other", encoding="utf-8-sig")
    assert text_to_freeze(file, begun_with) == complete_text(file)


@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"], ids=["", "mark"])
@pytest.mark.parametrize("end", [b"\n", b"\r\n"], ids=["LF", "CRLF"])
def test_files_that_windows_saves_without_changing_a_word_are_the_same_study(
    tmp_path: Path, mark: bytes, end: bytes
) -> None:
    file, consent = tmp_path / "study.yaml", tmp_path / "consent.md"
    texts = {file: WITH_FILE.encode(), consent: b"# Consent\n\nWe record how you play.\n"}
    for path, text in texts.items():
        path.write_bytes(text)
    plain, study = complete_text(file), read_study(file)
    earlier = "\ufeff" + plain.replace('"# Consent', '"\\U0000feff# Consent').replace("\\n", "\\r\\n")
    for path, text in texts.items():
        path.write_bytes(mark + text.replace(b"\n", end))
    assert text_to_freeze(file, None) == complete_text(file) == plain
    assert read_study(file) == study
    assert text_to_freeze(file, earlier) == earlier
    assert text_to_freeze(file, "\ufeff" + WITH_FILE) == "\ufeff" + WITH_FILE
    consent.write_bytes(mark + b"# Consent")
    assert text_to_freeze(file, earlier) != earlier


def test_what_windows_wrote_into_the_files_of_a_begun_study_is_no_change_of_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, consent = tmp_path / "study.yaml", tmp_path / "consent.md"
    file.write_text(WITH_FILE, encoding="utf-8")
    consent.write_bytes(b"# Consent\r\n")
    folder = StudyFolder(read_study(file), tmp_path / "data")
    with closing(folder.open()) as store, closing(folder.open_identities()):
        earlier = complete_text(file).replace("# Consent\\n", "\\U0000feff# Consent\\r\\n")
        freeze_study(store, "solo", earlier, {}, {})
        assert as_frozen(folder, store, file).study == folder.study
        backup = tmp_path / "backup.yaml"
        backup.write_text(earlier, encoding="utf-8")
        folder = StudyFolder(read_study(backup), tmp_path / "data")
        assert as_frozen(folder, store, backup).study == folder.study
    assert capsys.readouterr().err == ""
