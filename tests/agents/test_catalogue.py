"""From an id to an agent, and what is said when there is no way."""

import gc
import json
import sys
from pathlib import Path
from types import ModuleType

import pytest

from movingout.agents.catalogue import agent_card, agent_cards, load_agent, open_to_all, unseen_map
from movingout.agents.checkpoint.card import OTHER_MAPS
from movingout.agents.checkpoint.checkpoint import CARD, MODELS_VARIABLE, find_checkpoint, model_roots
from movingout.agents.errors import AgentError, CheckpointError
from movingout.maps import load_map, map_names
from movingout.maps.randomize import randomize
from movingout.server.cli import main
from tests.agents.support import HERE, Forward


def test_every_card_names_an_agent_that_can_be_loaded() -> None:
    for card in agent_cards():
        assert callable(load_agent(card.id).act)
        assert card.description and card.name


def test_options_reach_a_factory_of_the_user_with_their_types() -> None:
    agent = load_agent(f"{HERE}:Forward:rows=3,distance=0.5")
    assert isinstance(agent, Forward)
    assert (agent.rows, agent.distance) == (3, 0.5)


@pytest.mark.parametrize(
    ("agent_id", "sentence"),
    [
        (
            "scriptet",
            "unknown agent 'scriptet'; did you mean scripted? known: scripted, person, greedy, porter, novice, late",
        ),
        ("my_package/mine.py:Mine", "name the module instead of its file: my_package.mine:Mine"),
        ("mine.py", "unknown agent 'mine.py'; name the module instead of its file: mine:Factory"),
        (
            "family:greedy",
            "family:greedy names several partners; name one of them, which `movingout demos people` lists",
        ),
        ("a b:c", "unknown agent 'a b:c'; known: scripted"),
        ("familie", "unknown agent 'familie'; did you mean families? known: scripted,"),
        ("scripted:patient=3", "did you mean patience? known: heavy_first"),
        ("no_such_module:Factory", "cannot import 'no_such_module'"),
        ("famly:greedy", "cannot import 'famly': there is no such module; did you mean family?"),
        (f"{HERE}:Missing", "has no factory 'Missing'"),
        (f"{HERE}:HERE", f"'HERE' in '{HERE}' is a str, not a class or a function that makes agents"),
        (f"{HERE}:ending_factory", "could not be made: SystemExit: 2 (tests/agents/support.py, line"),
        (f"{HERE}:interrupting_factory", "could not be made: KeyboardInterrupt: mine (tests/agents/support.py, line"),
        (f"{HERE}:Forward:speed=1", "options: rows, execute, distance"),
        (f"{HERE}:Forward:rows", "options are written key=value"),
        (f"{HERE}:broken_factory", "could not be made: RuntimeError: no weights here"),
        (f"{HERE}:not_an_agent", "has no reset"),
        ("idle:speed=3", "options: none"),
    ],
)
def test_a_wrong_id_is_answered_with_a_sentence(agent_id: str, sentence: str) -> None:
    with pytest.raises(AgentError) as raised:
        load_agent(agent_id)
    assert sentence in str(raised.value)


def test_a_module_that_raises_what_ctrl_c_raises_cannot_be_imported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It ended the command as if somebody had pressed Ctrl-C."""
    (tmp_path / "interrupting_module.py").write_text("raise KeyboardInterrupt('mine')\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(AgentError, match="cannot import 'interrupting_module': KeyboardInterrupt: mine"):
        load_agent("interrupting_module:Agent")


def test_ctrl_c_while_an_agent_is_made_is_no_fault_of_it() -> None:
    with pytest.raises(KeyboardInterrupt):
        load_agent(f"{HERE}:pressing_factory")


def test_a_policy_of_the_running_script_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """A script has no import specification, and may define its policy itself."""
    script = ModuleType("__main__")
    script.Mine = Forward  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "__main__", script)
    assert isinstance(load_agent("__main__:Mine"), Forward)


@pytest.mark.parametrize(
    ("source", "sentence"),
    [
        (
            "import sys\n\nsys.exit(2)\n",
            "cannot import 'my_script': it ends the program while it is imported; put what it does as a script under "
            "if __name__ == '__main__': (my_script.py, line 3)",
        ),
        ("def reset(:\n", "cannot import 'my_script': SyntaxError: invalid syntax (my_script.py, line 1)"),
    ],
)
def test_a_script_that_cannot_be_imported_is_answered_with_one_sentence(
    source: str, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "my_script.py").write_text(source, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", [*sys.path, str(tmp_path)])
    with pytest.raises(AgentError) as raised:
        load_agent("my_script:Policy")
    assert str(raised.value) == sentence


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("source", "sentence"),
    [
        (
            "class Policy:\n    reset = print\n    async def act(self, seen): ...\n",
            "act() of Policy is async; nobody awaits",
        ),
        ("class Policy:\n    async def reset(self, episode): ...\n", "reset() of Policy is async; nobody awaits"),
        ("async def Policy(): ...\n", "my_async:Policy is async; what makes an agent is a plain function or a class"),
    ],
)
def test_async_agents_are_refused_before_they_play(
    source: str, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "my_async.py").write_text(source, encoding="utf-8")
    monkeypatch.setattr("sys.path", [*sys.path, str(tmp_path)])
    monkeypatch.delitem(sys.modules, "my_async", raising=False)
    with pytest.raises(AgentError) as raised:
        load_agent("my_async:Policy")
    assert sentence in str(raised.value)
    gc.collect()  # where Python would say that a coroutine was never awaited


def test_a_card_of_a_users_agent_is_made_without_importing_it() -> None:
    card = agent_card("no_such_module:Factory")
    assert (card.id, card.name, card.kind) == ("no_such_module:Factory", "Factory", "policy")
    with pytest.raises(AgentError, match="known: scripted, person, greedy"):
        agent_card("HandOf")


def test_a_trained_agent_says_which_map_it_never_saw_and_nobody_else_does() -> None:
    assert unseen_map("bass@all:lag=1", "Simple") == (
        "bass@all:lag=1 has never seen the map Simple: it was trained on 12 others."
    )
    assert [unseen_map("bass@all", name) for name in map_names()] == [""] * 12
    variant = randomize(load_map("HandOff"), 3)
    assert variant.variant and not unseen_map("bass@all", variant.name)
    assert not any(unseen_map(agent_id, "Simple") for agent_id in ("scripted:seed=3", "idle", f"{HERE}:Forward"))


def test_of_an_agent_whose_card_has_no_room_for_all_of_its_maps_no_map_is_said_to_be_new(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shipped = find_checkpoint("mlp@all", *model_roots()).card.model_dump(mode="json")
    folder = tmp_path / "mlp-many"
    folder.mkdir()
    monkeypatch.setenv(MODELS_VARIABLE, str(tmp_path))
    for maps, said in ((["HandOff"], True), (["HandOff", OTHER_MAPS], False)):
        (folder / CARD).write_text(json.dumps({**shipped, "id": "mlp@many", "maps": maps}))
        assert bool(unseen_map("mlp@many", "Simple")) == said


@pytest.fixture
def damaged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two agents of the user: one whose card says nothing of its kind, and a torn copy of a shipped one."""
    for folder, text in (("odd-mine", '{"schema_version": 1, "id": "odd@mine"}'), ("dp-all", "{torn")):
        (tmp_path / "data" / "models" / folder).mkdir(parents=True)
        (tmp_path / "data" / "models" / folder / "card.json").write_text(text)
    monkeypatch.chdir(tmp_path)


@pytest.mark.usefixtures("damaged")
def test_a_damaged_card_is_named_with_what_is_wrong_and_the_others_are_listed_all_the_same(
    capsys: pytest.CaptureFixture[str],
) -> None:
    for ask in (agent_card, load_agent):
        with pytest.raises(CheckpointError, match=r"odd-mine/card.json: name: Field required"):
            ask("odd@mine")
        with pytest.raises(CheckpointError, match=r"dp-all/card.json: the file: Invalid JSON"):
            ask("dp@all")
    ids = [card.id for card in agent_cards()]
    assert "bass@all" in ids and "odd@mine" not in ids and "dp@all" not in ids
    assert main(["agents", "show", "odd@mine"]) == 2
    assert "odd-mine/card.json: name: Field required" in capsys.readouterr().err
    assert main(["agents", "list"]) == 0
    printed = capsys.readouterr()
    assert "bass@all" in printed.out and "left out: odd-mine/card.json" in printed.err
    with pytest.raises(AgentError, match="known: bass@all,"):
        agent_card("nobody@all")


def test_a_trained_agent_that_does_not_exist_is_answered_with_those_that_do() -> None:
    for ask in (agent_card, load_agent):
        with pytest.raises(AgentError, match="dp@nowhere"):
            ask("dp@nowhere")


def test_a_variable_that_names_no_folder_of_models_is_told_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOVINGOUT_MODELS", str(tmp_path / "modles"))
    for ask in (agent_card, load_agent):
        with pytest.raises(AgentError, match=f"; MOVINGOUT_MODELS names {tmp_path / 'modles'}, which is no folder$"):
            ask("dp@nowhere")


def test_an_agent_around_another_is_open_to_all_where_the_other_is() -> None:
    assert all(map(open_to_all, ("late", "late:agent=scripted:seed=3;patience=40", "clone:policy=dp@all,seed=1")))
    wrong = (
        "late:agent=os:system",
        "late: agent =onnx:path=p.onnx",
        "clone:policy=os:system:x=@",
        "late:agent=ghost:f#red",
    )
    assert not any(map(open_to_all, wrong))


def test_what_is_no_text_names_no_agent() -> None:
    with pytest.raises(AgentError, match=r"the id of an agent is text, such as .*, not None"):
        load_agent(None)  # type: ignore[arg-type]
