"""A language model, in the form of a slow stand-in, plays in a room; strangers cannot name its address."""

import asyncio
import json
from pathlib import Path

import pytest

from movingout.agents.catalogue import load_agent
from movingout.agents.llm.model_id import KEY
from movingout.recordings import read_episode
from movingout.remote import Client
from movingout.server.cli import main
from tests.agents.llm.stand_in import Reply, said, stand_in
from tests.server.live import limits, serve

SECRET = "sk-secret"
FETCH = said(json.dumps({"plan": "I take one end.", "skills": [{"skill": "fetch", "item": 0}]})).body


@pytest.mark.slow
def test_it_plays_while_its_model_thinks_and_the_recording_tells_what_was_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(KEY, SECRET)

    async def played(address: str, room: str) -> int:
        async with Client(f"http://{address}", room) as client:
            return (await client.play(load_agent("scripted"))).ticks

    with stand_in(lambda _: Reply(FETCH, delay_s=1.0)) as model:
        agent_id = f"llm:model=m,url={model.url},every=1"
        with serve(tmp_path, limits(), partner=agent_id) as live:
            status, _ = live.call(
                "/api/rooms", {"maps": ["Simple"], "seats": [{"kind": "agent", "agent": agent_id + "1"}]}
            )
            assert status == 422
            room = live.open_room(agent_id, "remote", maps=("SingleRotation",), limit_ticks=60)["room"]
            asyncio.run(asyncio.wait_for(played(live.address, room), 60))
    assert model.keys and set(model.keys) == {f"Bearer {SECRET}"}
    (file,) = (tmp_path / "recordings").rglob("*.mcap")
    assert SECRET.encode() not in file.read_bytes()
    decisions = [one for one in read_episode(file).decisions if one.seat == 0]
    told = [one.detail for one in decisions if "question" in one.detail]
    assert told and float(str(told[0]["latency_s"])) >= 1.0 and "SingleRotation" in str(told[0]["prompt"])
    assert decisions[-1].detail["plan"] == "I take one end." and decisions[0].detail["skill"] == "help"
    assert sum(one.missed for one in decisions) < len(decisions) / 2


@pytest.mark.slow
def test_a_server_is_not_started_with_a_partner_that_nobody_answers_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    partner = "llm:model=m,url=http://127.0.0.1:9/v1"
    assert main(["play", "--partner", partner, "--data", str(tmp_path)]) == 2
    assert "nothing answers at http://127.0.0.1:9/v1" in capsys.readouterr().err
    with stand_in(lambda _: said("hi")) as model:
        assert main(["play", "--partner", f"llm:model=m,url={model.url},wait=yes", "--data", str(tmp_path)]) == 2
    assert "leave out wait=yes" in capsys.readouterr().err
