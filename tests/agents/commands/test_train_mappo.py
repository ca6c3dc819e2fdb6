"""`movingout train mappo` and `train comedi`: from a map to an agent in a seat, with the commands a user types."""

import dataclasses
import json
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("torchrl")

from movingout.agents.catalogue import load_agent, unseen_map
from movingout.agents.checkpoint.checkpoint import find_checkpoint
from movingout.agents.conformance import check_agent
from movingout.agents.data.rollout import rollout
from movingout.agents.errors import AgentError
from movingout.agents.kinds.registry import KINDS
from movingout.agents.reinforcement.mappo_config import MappoConfig
from movingout.agents.training.optimisation import Optimisation
from movingout.maps import load_map, map_to_json
from movingout.maps.randomize import pair_text, pairs_on
from movingout.server.cli import main
from tests.agents.trained import load_checkpoint

TINY = ["--frames", "24", "--frames-per-batch", "12", "--envs", "3", "--passes", "1", "--batch", "12", "--ticks", "5"]
SMALL_NET = ["--width", "16", "--depth", "1"]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.chdir(tmp_path)
    yield tmp_path


@pytest.mark.parametrize(
    ("kind", "options", "rounds"), [("mappo", ["--frames", "23"], 2), ("comedi", ["--members", "2"], 6)]
)
def test_it_writes_an_agent_that_plays(
    kind: str, options: list[str], rounds: int, here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    agent_id = f"{kind}@tiny"
    command = ["train", kind, "--map", "HandOff,LeftRight", "--id", agent_id, *TINY, *SMALL_NET, *options]
    assert main([*command, "--json"]) == 0
    shown = capsys.readouterr()
    assert json.loads(shown.out)["windows"] == 12 * rounds
    assert "24 of 24 frames, reward per tick" in shown.err
    assert ("23 frames become 24: 2 whole rounds" in shown.err) == (kind == "mappo")
    card = find_checkpoint(agent_id, here / "data" / "models").card
    assert (card.kind, card.maps, card.training.updates) == (kind, ("HandOff", "LeftRight"), rounds)
    check_agent(lambda: load_agent(agent_id), maps=["HandOff"], ticks=8)
    before = (here / "data" / "models" / f"{kind}-tiny" / "policy.safetensors").read_bytes()
    assert main(command) == 0, "nothing is left to do"
    assert (here / "data" / "models" / f"{kind}-tiny" / "policy.safetensors").read_bytes() == before
    assert main([*command, "--discount", "0.5"]) == 2
    assert "choose another --id, or continue with --go-on" in capsys.readouterr().err


def test_the_card_names_a_map_of_ones_own_by_its_name(here: Path) -> None:
    own = map_to_json(load_map("HandOff")) | {"name": "Garage", "title": "The Garage", "number": 0}
    (here / "own.json").write_text(json.dumps(own))
    assert main(["train", "mappo", "--map", str(here / "own.json"), "--id", "mappo@tiny", *TINY, *SMALL_NET]) == 0
    card = find_checkpoint("mappo@tiny", here / "data" / "models").card
    assert card.maps == ("Garage",) and "MAPPO on Garage:" in card.description
    assert not unseen_map("mappo@tiny", "Garage")


def test_other_maps_are_gone_on_with_on_purpose_and_only_if_they_are_played(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["train", "mappo", "--id", "mappo@tiny", *TINY, *SMALL_NET]
    assert main([*command, "--map", "HandOff"]) == 0
    assert main([*command, "--map", "LeftRight"]) == 2
    assert "map HandOff, not LeftRight; data of SHA-256" in capsys.readouterr().err
    assert main([*command, "--map", "LeftRight", "--go-on"]) == 2
    assert "mappo@tiny has made all of its 2 updates; to train on, give a larger --frames" in capsys.readouterr().err
    models = here / "data" / "models"
    assert find_checkpoint("mappo@tiny", models).card.maps == ("HandOff",)
    assert main([*command, "--map", "HandOff"]) == 0, "as if the other map had never been named"
    assert main([*command, "--map", "LeftRight", "--go-on", "--frames", "36", "--ticks", "2"]) == 0
    card = find_checkpoint("mappo@tiny", models).card
    both = frozenset(pair_text(pair) for name in ("HandOff", "LeftRight") for pair in pairs_on(load_map(name)))
    assert (card.maps, card.learned_items) == (("HandOff", "LeftRight"), both)
    assert "MAPPO on LeftRight, and on others before: 36 ticks" in card.description
    assert main([*command, "--map", "LeftRight", "--frames", "48", "--ticks", "2"]) == 0
    again = find_checkpoint("mappo@tiny", models).card
    assert (again.maps, again.learned_items) == (card.maps, both) and "and on others before" in again.description


def test_it_draws_as_in_training_or_plays_the_middle(here: Path) -> None:
    assert main(["train", "mappo", "--id", "mappo@tiny", "--split", "official", *TINY, *SMALL_NET]) == 0
    checkpoint = find_checkpoint("mappo@tiny", here / "data" / "models")
    designed = {pair_text(pair) for pair in pairs_on(load_map("HandOff"))}
    learned = checkpoint.card.learned_items
    assert learned and designed.isdisjoint(learned), "the split `official` has no item as on the map as designed"

    def played(noise: float, seed: int) -> list[list[float]]:
        agents = load_checkpoint(checkpoint, noise=noise), load_checkpoint(checkpoint, noise=noise)
        return [step.after.robot_poses.ravel().tolist() for step in rollout(load_map("HandOff"), agents, seed, 6)]

    assert played(1.0, 0) == played(1.0, 0) != played(1.0, 1)
    assert played(0.0, 0) == played(0.0, 1)
    with pytest.raises(AgentError, match="noise is a number from 0 to 2"):
        load_checkpoint(checkpoint, noise=3.0)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--frames", "0"], "--frames 0: input should be greater than or equal to 1"),
        (["--frames", "1"], "--frames 1 is less than a round, after which something is learned; give at least 6,000"),
        (["--map", "HandOf"], "did you mean HandOff"),
        (["data/demos"], "mappo learns from its own play, on maps that --map names; leave out the recordings"),
        (
            ["--without", "family:greedy"],
            "mappo learns from its own play, on maps that --map names; leave out --without",
        ),
        (["--envs", "20", "--frames-per-batch", "10"], "20 environments play at least one"),
        (["--width", "2"], "--width 2"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(
    words: list[str], sentence: str, here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["train", "mappo", *words]) == 2
    shown = capsys.readouterr().err
    assert sentence in shown and "Traceback" not in shown
    assert not (here / "data").exists()


def test_without_torchrl_it_says_what_to_install(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in list(sys.modules):
        if name.startswith(("torchrl", "movingout.agents.reinforcement.")) and not name.endswith("config"):
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "torchrl", None)
    assert main(["train", "mappo", *TINY]) == 2
    assert "reinforcement learning needs the extra `rl`; install it with: " in capsys.readouterr().err


def test_the_preset_paper_has_the_numbers_of_the_paper() -> None:
    paper = KINDS["mappo"].presets["paper"]
    common = {entry.name for entry in dataclasses.fields(Optimisation)} - {"batch", "rate", "clip"}
    numbers = {name: value for name, value in dataclasses.asdict(paper).items() if name not in common}
    assert numbers == {
        "frames": 30_000_000, "frames_per_batch": 6000, "envs": 10, "passes": 45, "batch": 400, "rate": 5e-5,
        "clip": 5.0, "clip_ratio": 0.2, "discount": 0.99, "trace": 0.9, "critic_weight": 1.0, "entropy": 0.0,
        "width": 256, "depth": 2, "ticks": 1000, "reward": "paper-dense", "layout": "official-v1", "grasp": "toggle",
        "normalise": False,
    }  # fmt: skip


def test_on_maps_of_coordination_the_paper_has_others(here: Path) -> None:
    def begun(map_name: str, *words: str) -> tuple[float, ...]:
        seen.clear()
        assert (
            main(["train", "mappo", "--preset", "paper", "--map", map_name, "--id", f"mappo@x{len(ids)}", *words]) == 0
        )
        ids.append(map_name)
        return seen[0].ticks, seen[0].entropy, seen[0].discount

    seen: list[MappoConfig] = []
    ids: list[str] = []
    few = ["--frames", "12", "--frames-per-batch", "12", "--envs", "2", "--passes", "1", "--width", "8"]
    from movingout.agents.reinforcement import mappo

    init = mappo.Mappo.__init__

    def noted(self: mappo.Mappo, config: MappoConfig, *others: object, **named: object) -> None:
        seen.append(config)
        init(self, config, *others, **named)  # type: ignore[arg-type]

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(mappo.Mappo, "__init__", noted)
        assert begun("DistancePriority", *few) == (1000, 0.0, 0.99)
        assert begun("HandOff", *few) == (3000, 0.00065, 0.92)
        assert begun("HandOff", *few, "--discount", "0.99", "--ticks", "9") == (9, 0.00065, 0.99)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["mappo", "comedi"])
def test_its_matches_are_recorded_and_verified(kind: str, here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    train = ["train", kind, "--map", "DistancePriority", "--frames", "6000", "--id", f"{kind}@six"]
    assert main(train) == 0
    match = ["match", "--blue", f"{kind}@six", "--red", f"{kind}@six:noise=0", "--map", "DistancePriority"]
    assert main([*match, "--record", "played"]) == 0
    assert main(["recordings", "verify", "played"]) == 0
    check_agent(lambda: load_agent(f"{kind}@six"))
