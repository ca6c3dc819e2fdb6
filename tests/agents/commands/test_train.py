"""From recordings to an agent in a seat, with the commands a user types."""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import load

from movingout.agents.action_chunk import checked_chunk
from movingout.agents.base import EpisodeInfo
from movingout.agents.bass.recombination import LENGTH
from movingout.agents.checkpoint.checkpoint import CARD, find_checkpoint
from movingout.agents.data.corrections import save_correction
from movingout.agents.data.dagger import LabellingJob, label_episode
from movingout.agents.inference.policy_agent import agent_rows
from movingout.agents.observation.seat_observation import observe
from movingout.maps import load_map
from movingout.maps.randomize import pair_text, pairs_on
from movingout.server.cli import main
from movingout.world import World
from tests.agents.learning import recorded
from tests.agents.support import HERE
from tests.agents.trained import load_checkpoint

pytestmark = pytest.mark.slow

TINY = ["--updates", "6", "--batch", "32", "--width", "16", "--depth", "1", "--evaluate-every", "3"]


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recordings")
    for number in range(3):
        recorded(folder, f"e{number}", ticks=30, seed=number, people=(f"p{number}", f"q{number}"))
    return folder


def test_training_writes_an_agent_that_plays(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["train", "dp", str(recordings), "--id", "dp@tiny", "--data", str(tmp_path), "--json", *TINY]) == 0
    assert json.loads(capsys.readouterr().out)["windows"] == 3 * 2 * 30
    card = find_checkpoint("dp@tiny", tmp_path / "models").card
    assert (card.training.episodes, card.maps, card.network.width) == (3, ("HandOff",), 16)
    assert card.learned_items == frozenset(map(pair_text, pairs_on(load_map("HandOff"))))
    run = tmp_path / "runs" / "dp-tiny"
    assert json.loads((run / "config.json").read_text())["batch"] == 32
    assert list(run.glob("events.*"))

    agent = load_checkpoint(find_checkpoint("dp@tiny", tmp_path / "models"))
    world = World(load_map("HandOff"))
    agent.reset(EpisodeInfo(world.map, 0, 1, 50))
    for _ in range(5):
        chunk = checked_chunk(agent.act(observe(world.map, world.state(), 0)))
        assert len(chunk) in (8, 7)  # decides every second tick and plays the rest of its plan in between
        row = chunk[0]
        world.step([[row[0], np.arctan2(row[2], row[1]), row[3]], [0, 0, 0]])


def test_augmentation_adds_windows_that_the_engine_confirmed(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["train", "mlp", str(recordings), "--id", "mlp@more", "--data", str(tmp_path), *TINY, "--json"]
    assert main([*command, "--recombine", "0.5", "--pose-noise", "0.002"]) == 0
    captured = capsys.readouterr()
    assert "pieces valid" in captured.err
    assert json.loads(captured.out)["windows"] >= 180


def test_an_id_with_the_name_of_another_kind_is_refused_before_anything_is_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["train", "mlp", str(tmp_path / "nowhere"), "--data", str(tmp_path), *TINY]
    assert main([*command, "--id", "dp@q"]) == 2
    assert "dp@q would be an agent of kind mlp with the name of another; take --id mlp@q" in capsys.readouterr().err
    assert not (tmp_path / "models").exists() and not (tmp_path / "runs").exists()
    for agent_id in ("mlp@q", "dp-like@q", "baseline@q"):
        assert main([*command, "--id", agent_id]) == 2
        assert "nowhere" in capsys.readouterr().err
    assert main(["train", "response", "--base", "dp@nobody", "--id", "dp@q", "--data", str(tmp_path)]) == 2
    assert "no checkpoint 'dp@nobody'" in capsys.readouterr().err, "what steers a policy of kind dp is of kind dp"


def test_a_card_says_that_participants_were_simulated(tmp_path: Path) -> None:
    recorded(tmp_path, "programs", ticks=30, simulated=True, kinds=("human", "human"))
    few = ["--id", "mlp@few", "--data", str(tmp_path), *TINY]
    assert main(["train", "mlp", str(tmp_path / "programs.mcap"), *few]) == 0
    card = find_checkpoint("mlp@few", tmp_path / "models").card
    assert card.training.population == "2 simulated participants"
    assert card.description == "MLP trained on 1 episode of 2 simulated participants."
    recorded(tmp_path, "people", ticks=30, people=("c", "d"), kinds=("human", "human"))
    both = [str(tmp_path / f"{name}.mcap") for name in ("people", "programs")]
    assert main(["train", "mlp", *both, *few, "--id", "mlp@both"]) == 0
    both_card = find_checkpoint("mlp@both", tmp_path / "models").card
    assert both_card.training.population == "4 participants, some of them simulated"


def test_the_ablation_of_recombination_asks_for_one_end_only(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def draw_pieces(_parts: object, _seed: int, matching: str) -> Iterator[object]:
        asked.append(matching)
        return iter(())

    monkeypatch.setattr("movingout.agents.bass.recombination.draw_pieces", draw_pieces)
    command = [
        "train",
        "mlp",
        str(recordings),
        "--id",
        "mlp@more",
        "--data",
        str(tmp_path),
        *TINY,
        "--recombine",
        "0.5",
    ]
    assert main(command) == main([*command, "--matching", "one-end", "--id", "mlp@one"]) == 0
    assert asked == ["both-ends", "one-end"]


def test_an_experts_labels_are_augmented_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ahead = f"{HERE}:Forward:distance=0.2"
    for number in range(2):
        job = LabellingJob(load_map("FourCorners"), ahead, ahead, (f"p{number}", "idle"), 1, seed=number, ticks=30)
        save_correction(tmp_path / f"{number}.corrections.npz", label_episode(job, slips=False))
    command = ["train", "mlp", str(tmp_path), "--id", "mlp@more", "--data", str(tmp_path), *TINY, "--json"]
    assert main([*command, "--recombine", "0.5"]) == 0
    captured = capsys.readouterr()
    assert "4 of 4 pieces valid" in captured.err
    assert json.loads(captured.out)["windows"] == 2 * 30 + 4 * LENGTH


def test_an_interrupted_training_goes_on_where_it_was(recordings: Path, tmp_path: Path) -> None:
    command = ["train", "mlp", str(recordings), "--id", "mlp@tiny", "--data", str(tmp_path), *TINY]
    assert main(command) == 0
    curve = tmp_path / "runs" / "mlp-tiny" / "losses.jsonl"
    assert [json.loads(line)["update"] for line in curve.read_text().splitlines()] == [3, 6]
    assert main([*command, "--updates", "9"]) == 0
    assert [json.loads(line)["update"] for line in curve.read_text().splitlines()] == [3, 6, 9]
    assert main([*command, "--width", "8"]) == 2


def test_a_training_that_is_done_says_so_and_the_card_says_what_was_done(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["train", "mlp", str(recordings), "--id", "mlp@tiny", "--data", str(tmp_path), *TINY]
    assert main([*command, "--updates", "2", "--epochs", "1"]) == 0  # one pass over 150 windows, 32 at a time
    card = find_checkpoint("mlp@tiny", tmp_path / "models").card
    assert card.training.updates == 5
    capsys.readouterr()
    assert main([*command, "--updates", "4"]) == 0
    assert "already trained 5 updates; nothing is left to do" in capsys.readouterr().err
    again = find_checkpoint("mlp@tiny", tmp_path / "models").card
    assert again.training.updates == 5 and again.files == card.files


def test_other_data_is_learned_from_under_another_id_or_on_purpose(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recorded(tmp_path / "more", "other", ticks=20, seed=9, the_map=load_map("FourCorners"))
    command = ["train", "mlp", "--id", "mlp@tiny", "--data", str(tmp_path), *TINY]
    assert main([*command, str(recordings)]) == 0
    card = find_checkpoint("mlp@tiny", tmp_path / "models").card
    run = tmp_path / "runs" / "mlp-tiny"
    config = json.loads((run / "config.json").read_text())
    assert (config["preset"], config["seed"], config["data_sha256"]) == ("fast", 0, card.training.data_sha256)
    assert (run / "card.json").read_bytes() == (tmp_path / "models" / "mlp-tiny" / "card.json").read_bytes()

    capsys.readouterr()
    assert main([*command, str(tmp_path / "more"), "--updates", "9"]) == 2
    said = capsys.readouterr().err
    assert "started with data of SHA-256" in said and "another --id" in said and "--go-on" in said
    assert find_checkpoint("mlp@tiny", tmp_path / "models").card == card
    assert main([*command, str(tmp_path / "more"), "--updates", "9", "--go-on"]) == 0
    both = find_checkpoint("mlp@tiny", tmp_path / "models").card
    more = both.training
    assert (more.updates, more.episodes) == (9, 1) and more.data_sha256 != card.training.data_sha256
    assert both.maps == tuple(sorted({*card.maps, "FourCorners"})) and set(card.training.items or ()) < set(
        more.items or ()
    )
    assert card.description.endswith(".") and "before" not in card.description
    assert both.description.startswith("MLP trained on 1 episode of ")
    assert both.description.endswith(", and on others before.")


def test_the_card_of_bass_says_where_the_simulator_and_the_value_come_from(recordings: Path, tmp_path: Path) -> None:
    longer = tmp_path / "longer"
    recorded(longer, "long", ticks=80, seed=5, people=("ann", "bob"))
    data = ["--data", str(tmp_path)]
    assert main(["train", "mlp", str(recordings), "--id", "mlp@tiny", *data, *TINY]) == 0
    bass = ["train", "bass", "--base", "mlp@tiny", *data, "--batch", "8"]
    own = ["--updates", "2", "--width", "8", "--latent", "2", "--value-width", "8", "--value-updates", "3"]
    assert main([*bass, str(longer), "--id", "bass@tiny", *own, "--population", "two friends"]) == 0
    policy = find_checkpoint("mlp@tiny", tmp_path / "models").card.training
    card = find_checkpoint("bass@tiny", tmp_path / "models").card
    simulator, value = card.dynamics_training, card.value_training
    assert card.training == policy and simulator is not None and value is not None
    assert (simulator.episodes, simulator.windows, simulator.updates) == (1, 80, 2)
    assert (value.windows, value.updates, value.population) == (2 * 20, 3, "two friends")
    assert simulator.data_sha256 == value.data_sha256 != policy.data_sha256
    taken = ["--id", "bass@other", "--simulator", "bass@tiny", "--value", "bass@tiny"]
    assert main([*bass, *taken, "--base", "mlp@tiny"]) == 0
    other = find_checkpoint("bass@other", tmp_path / "models").card
    assert (other.dynamics_training, other.value_training) == (simulator, value)


def test_what_was_trained_now_is_what_is_told_of(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    longer = tmp_path / "longer"
    recorded(longer, "long", ticks=80, seed=5, people=("ann", "bob"))
    data = ["--data", str(tmp_path)]
    assert main(["train", "mlp", str(recordings), "--id", "mlp@tiny", *data, *TINY]) == 0
    bass = ["train", "bass", str(longer), "--base", "mlp@tiny", *data, "--batch", "8"]
    assert main([*bass, "--id", "bass@nfd", "--updates", "2", "--width", "8", "--latent", "2", "--score", "nfd"]) == 0
    own = ["--simulator", "bass@nfd", "--value-width", "8", "--value-updates", "3"]
    capsys.readouterr()
    assert main([*bass, "--id", "bass@tiny", *own, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["updates"] == 3  # of the value


def test_a_bass_that_could_not_play_is_refused_before_anything_is_trained(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = ["--data", str(tmp_path)]
    assert main(["train", "mlp", str(recordings), "--id", "mlp@tiny", *data, *TINY]) == 0
    bass = ["train", "bass", str(recordings), "--id", "bass@tiny", "--base", "mlp@tiny", *data]
    for words, said in (
        (["--depth", "16"], "mlp@tiny predicts 8 ticks, so --depth 16 is too far; --depth 8"),
        (["--score", "nfd", "--value", "bass@all"], "--value bass@all is for --score value, not for --score nfd"),
    ):
        capsys.readouterr()
        assert main([*bass, *words]) == 2
        assert said in capsys.readouterr().err
    assert not (tmp_path / "runs" / "bass-tiny").exists()


def test_going_on_with_other_data_and_no_updates_left_is_refused(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["train", "mlp", "--id", "mlp@tiny", "--data", str(tmp_path), *TINY, "--go-on"]
    assert main([*command, str(recordings)]) == 0
    before = find_checkpoint("mlp@tiny", tmp_path / "models")
    assert main([*command, str(recordings)]) == 0
    recorded(tmp_path / "more", "more", ticks=20, people=("cy", "dee"))
    for _ in range(2):
        assert main([*command, str(tmp_path / "more")]) == 2
        assert "mlp@tiny has made all of its 6 updates; to train on, give a larger --updates" in capsys.readouterr().err
    assert main([*command[:-1], str(tmp_path / "more")]) == 2
    assert "this run was started with data of SHA-256" in capsys.readouterr().err
    assert (
        find_checkpoint("mlp@tiny", tmp_path / "models").card.training.data_sha256 == before.card.training.data_sha256
    )


def test_an_id_whose_folder_is_another_agents_is_refused(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["train", "mlp", str(recordings), "--data", str(tmp_path), *TINY]
    assert main([*command, "--id", "mlp-a@b"]) == 0
    assert main([*command, "--id", "mlp@a-b"]) == 2
    assert "is the folder of mlp-a@b; choose another id than mlp@a-b" in capsys.readouterr().err


def test_who_stands_idle_is_not_learned_from_unless_it_is_asked_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recorded(tmp_path, "one", ticks=20, people=("ann", "idle"))
    command = ["train", "mlp", str(tmp_path), "--data", str(tmp_path), *TINY, "--json"]
    windows = {}
    for seats in ("acting", "all"):
        assert main([*command, "--id", f"mlp@{seats}-seats", "--seats", seats]) == 0
        printed = capsys.readouterr()
        windows[seats] = json.loads(printed.out)["windows"]
        assert ("1 of 2 seats are not learned from" in printed.err) == (seats == "acting")
    assert windows == {"acting": 20, "all": 40}
    assert main([*command, "--id", "mlp@human", "--seats", "human"]) == 2
    assert "no recording has a seat to learn from" in capsys.readouterr().err


def test_a_family_of_partners_is_left_out_of_the_training_data(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    partners = ("greedy:seed=0,order=near,patience=40", "novice:seed=0,learns_in=100", "person:name=B02")
    for number, partner in enumerate(partners):  # as matches call them
        recorded(tmp_path, f"match{number}", ticks=20, seed=number, people=("dp@all", partner))
    for number, name in enumerate(("greedy03", "B01")):  # as `demos label` does
        job = LabellingJob(load_map("HandOff"), "scripted", "scripted", (name, "greedy:seed=2"), 0, number, 25)
        save_correction(tmp_path / f"label{number}.corrections.npz", label_episode(job))
    command = ["train", "mlp", str(tmp_path), "--data", str(tmp_path / "data"), *TINY, "--json"]
    episodes = {}
    for name, left_out in (
        ("whole", []),
        ("greedy", ["--without", "family:greedy"]),
        ("two", ["--without", "family:greedy", "--without", "people:B"]),
    ):
        assert main([*command, "--id", f"mlp@{name}", *left_out]) == 0
        episodes[name] = json.loads(capsys.readouterr().out)["episodes"]
    assert episodes == {"whole": 5, "greedy": 3, "two": 1}
    for names, refused in (
        (["family:porter"], "nobody named by --without family:porter plays in any of these 5 episodes"),
        (["family:gredy"], "unknown family 'gredy'"),
        (["dp@all", "family:greedy", "B01"], "somebody who is to be left out plays in every episode"),
    ):
        assert main([*command, "--id", "mlp@none", *(word for name in names for word in ("--without", name))]) == 2
        assert refused in capsys.readouterr().err


def test_it_is_said_where_an_agent_is_looked_for_when_its_data_lies_elsewhere(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    command = ["train", "mlp", str(recordings), "--id", "mlp@tiny", *TINY]
    assert main(command) == 0
    assert "copy" not in capsys.readouterr().out
    assert main([*command, "--data", "elsewhere"]) == 0
    last = capsys.readouterr().out.splitlines()[-1]
    models = "elsewhere/models"
    assert last == (
        f"to play with it, set MOVINGOUT_MODELS={models} for `play`, `match` and `agents`, or copy "
        f"{models}/mlp-tiny to data/models"
    )
    monkeypatch.setenv("MOVINGOUT_MODELS", models)
    assert main([*command, "--data", "elsewhere"]) == 0
    assert "to play with it" not in capsys.readouterr().out


def test_an_agent_to_start_from_is_found_where_the_variable_says(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["train", "mlp", str(recordings), "--id", "mlp@tiny", *TINY, "--data", "elsewhere"]) == 0
    monkeypatch.setenv("MOVINGOUT_MODELS", "elsewhere/models")
    assert main(["train", "mlp", str(recordings), "--id", "mlp@next", "--start", "mlp@tiny", *TINY, "--data", "b"]) == 0
    assert (tmp_path / "b" / "models" / "mlp-next" / "card.json").is_file()


def test_recordings_of_another_format_are_refused_in_a_sentence(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("movingout.recordings.file_format.metadata.FORMAT_VERSION", 99)
    assert main(["train", "mlp", str(recordings), "--id", "mlp@tiny", "--data", str(tmp_path), *TINY]) == 2
    said = capsys.readouterr().err
    assert "e0.mcap" in said and "is not the format 99 of this program" in said and "Traceback" not in said


def test_an_agent_starts_from_the_weights_of_another_and_is_shaped_as_it_is(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["train", "mlp", str(recordings), "--data", str(tmp_path), "--batch", "32", "--warmup", "1"]
    few = ["--updates", "1", "--rate", "1e-9"]  # one step that changes next to nothing
    assert main([*command, "--id", "mlp@base", *TINY, "--seed", "1", "--execute", "3"]) == 0
    assert main([*command, "--id", "mlp@tuned", "--start", "mlp@base", *few]) == 0
    assert main([*command, "--id", "mlp@fresh", "--width", "16", "--depth", "1", *few]) == 0
    base, tuned, fresh = (find_checkpoint(f"mlp@{name}", tmp_path / "models") for name in ("base", "tuned", "fresh"))
    assert tuned.card.network == base.card.network
    assert "starting from mlp@base" in tuned.card.description
    assert tuned.card.learned_items == base.card.learned_items != frozenset()
    (base.folder / CARD).write_text(base.card.model_dump_json(exclude={"training": {"items"}}), encoding="utf-8")
    assert main([*command, "--id", "mlp@again", "--start", "mlp@base", *few]) == 0
    assert find_checkpoint("mlp@again", tmp_path / "models").card.learned_items is None, "mlp@base no longer says"
    weights = [load(one.read("policy.safetensors")) for one in (base, tuned, fresh)]
    assert all(np.allclose(weights[0][name], weights[1][name], atol=1e-3) for name in weights[0])
    assert not all(np.allclose(weights[0][name], weights[2][name], atol=1e-3) for name in weights[0])

    long = f"{'b' * 48}@{'b' * 48}"
    assert main([*command, "--id", long, *TINY]) == 0
    assert main([*command, "--id", "mlp@long", "--start", long, "--population", "p" * 300, *few]) == 0
    assert find_checkpoint("mlp@long", tmp_path / "models").card.description.endswith("…")

    capsys.readouterr()
    assert main(["train", "gru", str(recordings), "--data", str(tmp_path), "--start", "mlp@base"]) == 2
    assert "--start mlp@base: it is of kind mlp; use `train mlp`" in capsys.readouterr().err


def test_the_same_seed_gives_the_same_weights(recordings: Path, tmp_path: Path) -> None:
    cards = []
    for place in ("one", "two"):
        folder = tmp_path / place
        assert main(["train", "mlp", str(recordings), "--id", "mlp@tiny", "--data", str(folder), *TINY]) == 0
        cards.append(find_checkpoint("mlp@tiny", folder / "models").card)
    assert cards[0].files == cards[1].files


def test_chunks_become_rows_with_unit_headings_and_presses_that_follow_the_hand() -> None:
    chunk = np.array([[2.0, 3.0, 4.0, -1, 1], [0.5, 0.0, 0.0, 1, -1]], dtype=np.float32)
    rows = agent_rows(chunk, holding=False, levels=True)
    assert np.allclose(rows, [[1.0, 0.6, 0.8, 1.0], [0.5, 1.0, 0.0, 1.0]])
    assert agent_rows(chunk, holding=True, levels=True)[:, 3].tolist() == [0.0, 1.0]
    assert agent_rows(chunk, holding=True, levels=False)[:, 3].tolist() == [1.0, 0.0]
