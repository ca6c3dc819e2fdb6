"""The registry of families: names that stand for several partners, one left out, and what commands do with them."""

import json
import sys
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from movingout.agents.catalogue import load_agent
from movingout.agents.checkpoint.checkpoint import SHIPPED
from movingout.agents.curriculum.partners import clone_stage
from movingout.agents.curriculum.recipe import Sizes
from movingout.agents.curriculum.recipe_anywhere import check_partners
from movingout.agents.environment.partners import partner_groups
from movingout.agents.errors import AgentError, DataError
from movingout.agents.partners.families import MEMBERS, Family, families, group, is_group, member, to_try
from movingout.agents.partners.families import test_people_caution as caution
from movingout.server.cli import main
from tests.support import ROOT

BUILT_IN = ("planner", "greedy", "porter", "novice", "late", "clone")


def test_six_families_are_there_without_any_training_and_each_has_twenty_members() -> None:
    known = families()
    assert [len(known[name].members) for name in BUILT_IN[:5]] == [MEMBERS] * 5
    assert len(known["clone"].members) >= MEMBERS // 2  # with the shipped policies alone
    for name in BUILT_IN:
        assert len({partner.agent_id for partner in known[name].members}) == len(known[name].members)


@pytest.mark.parametrize("name", BUILT_IN)
def test_members_can_be_loaded(name: str) -> None:
    for partner in families()[name].members[:4]:
        assert callable(load_agent(partner.agent_id).act)


def test_all_families_come_in_turn_and_one_can_be_left_out() -> None:
    everybody, others = group("families"), group("families:without-greedy")
    trained = [family for family in families().values() if family.trains and family.members]
    assert len(everybody) == MEMBERS * len(trained) and len(others) == len(everybody) - MEMBERS
    assert [partner.name[:-2] for partner in everybody[: len(trained)]] == [family.name for family in trained]
    assert not any(partner.name.startswith("greedy") for partner in others)
    assert {partner.agent_id for partner in others} < {partner.agent_id for partner in everybody}


def test_nobody_of_population_c_is_in_a_family() -> None:
    assert not any("name=C" in partner.agent_id for family in families().values() for partner in family.members)


def test_a_name_stands_for_another_member_in_each_episode_and_an_id_for_itself() -> None:
    assert member("family:greedy", 0) != member("family:greedy", 1)
    assert member("family:greedy", 3) == member("family:greedy", 3 + MEMBERS)
    assert member("people:A", 2) == "person:name=A03" and member("idle", 7) == "idle"
    assert is_group("people:C") and is_group("families") and not is_group("greedy")


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("family:gready", "unknown family 'gready'; did you mean greedy?"),
        ("families:without-nobody", "unknown family 'nobody'"),
        ("people:Z", "unknown population 'Z'"),
    ],
)
def test_an_unknown_group_is_refused_with_the_known_ones(name: str, sentence: str) -> None:
    with pytest.raises(AgentError) as raised:
        group(name)
    assert sentence in str(raised.value)


def test_a_family_of_trained_partners_has_the_members_whose_checkpoints_are_here(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    ids = ("clone:policy=dp@all,seed=1", "clone:policy=nobody@here")
    learned = Family("learned", "a test", ids)
    assert [partner.agent_id for partner in learned.members] == [ids[0]]
    (one,) = replace(learned, ids=ids[::-1]).members
    assert (one.name, one.agent_id) == ("learned02", ids[0]), "a name does not depend on who else is here"
    monkeypatch.setattr(
        "movingout.agents.partners.families.families", lambda: {"learned": replace(learned, ids=ids[1:])}
    )
    with pytest.raises(AgentError, match="family 'learned' has no trained members here: clone:policy=nobody@here"):
        group("family:learned")


def test_the_pages_say_how_many_members_ship(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("movingout.agents.partners.families.model_roots", lambda: (SHIPPED,))
    sizes = {name: len(family.members) for name, family in families().items()}
    assert {name: size for name, size in sizes.items() if size != MEMBERS} == {"clone": 10}
    learning, matches = (" ".join((ROOT / f"docs/{page}.md").read_text().split()) for page in ("learning", "matches"))
    assert "each has twenty members (`clone` ten of them until" in learning
    both_seats = 2 * MEMBERS, 2 * sizes["clone"], 2 * len(group("families"))
    said = "{} of a family, {} of family:clone with the policies that ship, {} of families".format(*both_seats)
    assert said in matches.replace("# ", "")


def test_the_recipe_of_clones_trains_what_the_family_names(tmp_path: Path) -> None:
    trained = {step.agent_id for step in clone_stage(Sizes(data=tmp_path))}
    named = {agent_id.partition("policy=")[2].partition(",")[0] for agent_id in families()["clone"].ids}
    assert trained <= named and len(trained) == 6


def test_an_environment_draws_from_a_family() -> None:
    (ids,) = partner_groups("family:novice")
    assert ids == tuple(partner.agent_id for partner in families()["novice"].members)


def test_demonstrations_are_played_by_a_family(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = "demos generate --population family:greedy --people 2 --map Simple --episodes 1 --ticks 5 --workers 1"
    assert main([*command.split(), "--json", "--out", str(tmp_path)]) == 0
    assert json.loads(capsys.readouterr().out)["episodes"] == 1
    assert [path.name for path in tmp_path.glob("*.mcap")] == ["family-greedy1s0-Simple-greedy01greedy02-00.mcap"]
    assert main(["demos", "generate", "--population", "family:x", "--out", str(tmp_path)]) == 2
    assert "unknown family 'x'" in capsys.readouterr().err


def test_families_are_listed_with_the_people(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demos", "people"]) == 0
    printed = capsys.readouterr().out
    assert "family:greedy: takes the nearest item" in printed and "porter20  porter:seed=19" in printed
    assert main(["demos", "people", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert set(listed["populations"]) == set("ABC") and listed["families"]["late"]["trains"] is True


def test_who_trains_with_people_of_c_is_told_that_they_are_for_tests() -> None:
    assert caution(["families", "people:B", "family:greedy"]) == ""
    assert caution(["families", "people:C"]) == caution(["C"]) != ""


def test_a_list_of_ones_own_is_a_group(tmp_path: Path) -> None:
    file = tmp_path / "partners.txt"
    file.write_text("# mine\nmy_lab.partners:Careful:speed=0.5,lag=2\nfamily:greedy\nperson:name=A03\n")
    listed = group(f"@{file}")
    assert listed[0].agent_id == member(f"@{file}", 0) == "my_lab.partners:Careful:speed=0.5,lag=2"
    assert listed[1:-1] == families()["greedy"].members
    assert [listed[0].name, listed[-1].name] == ["my-lab.partners-Careful-speed-0.5-lag-2", "A03"]
    assert is_group(f"@{file}")
    assert to_try(f"@{file}") == tuple(one.agent_id for one in listed) and to_try("people:B") == ("person:name=B01",)


def test_names_on_a_list_are_short_enough_for_files_and_differ(tmp_path: Path) -> None:
    ids = [f"latent@families:z={'/'.join(['0.123'] * 12)}/{last}" for last in (1, 2)]
    (tmp_path / "worst.txt").write_text("\n".join(ids))
    one, other = (partner.name for partner in group(f"@{tmp_path / 'worst.txt'}"))
    assert one != other and len(one) < 60 and "@" in one  # with the sign it counts as an agent, not as a person
    (tmp_path / "worst.txt").write_text("lab:Driver:speed=0.5\nlab:Driver:speed=-0.5")
    assert len({partner.name for partner in group(f"@{tmp_path / 'worst.txt'}")}) == 2


def test_everybody_on_a_list_is_made_before_an_environment_or_a_match_begins(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "partners.txt").write_text("idle\nlab.nowhere:Driver\n")
    named = f"@{tmp_path / 'partners.txt'}"
    with pytest.raises(AgentError, match=r"lab\.nowhere"):
        partner_groups(["idle", named])
    words = ["--blue", "idle", "--red", named, "--map", "Simple", "--episodes", "1", "--ticks", "1"]
    assert main(["match", *words, "--workers", "1"]) == 2
    assert "lab.nowhere" in capsys.readouterr().err
    (tmp_path / "partners.txt").write_text("idle\nperson:name=A03\n")
    assert partner_groups(["idle", named]) == (("idle",), ("idle", "person:name=A03"))


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("# nobody\n", "names nobody; write the id of an agent per line"),
        ("idle\n\n@more.txt", "line 3: a list names no other list, such as @more.txt"),
        ("family:gready", "line 1: unknown family 'gready'; did you mean greedy?"),
        ("\xff", "is no text in UTF-8"),
    ],
)
def test_a_list_without_partners_is_refused(content: str, sentence: str, tmp_path: Path) -> None:
    (tmp_path / "partners.txt").write_text(content, encoding="latin-1")
    with pytest.raises(AgentError) as raised:
        group(f"@{tmp_path / 'partners.txt'}")
    assert sentence in str(raised.value)


@pytest.mark.parametrize(
    ("name", "sentence"),
    [("@none.txt", "cannot read the list of partners none.txt: No such file"), ("@", "as in @partners.txt")],
)
def test_a_list_that_is_not_there_is_refused(name: str, sentence: str) -> None:
    with pytest.raises(AgentError, match=sentence):
        group(name)
    with pytest.raises(AgentError, match=f"{name} names several partners; name one of them$"):
        load_agent(name)


def test_demonstrations_are_played_by_a_list(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, out = tmp_path / "mine.txt", tmp_path / "out"
    file.write_text("greedy:order=heavy\nporter:patience=80\n")
    command = f"demos generate --population @{file} --map Simple --episodes 1 --ticks 5 --workers 1 --out {out}"
    assert main(command.split()) == 0
    assert [path.name for path in out.glob("*.mcap")] == ["mine1s0-Simple-greedy-order-heavyporter-patience-80-00.mcap"]
    file.write_text("greedy\nporter\nidle\n")
    assert main(command.split()) == 2 and main([*command.split(), "--people", "2"]) == 0
    assert "names 3 partners; pairs take an even number" in capsys.readouterr().err


@pytest.mark.parametrize("action", ["generate", "label"])
def test_everybody_on_a_list_is_made_before_anything_is_played(
    action: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "mine.txt").write_text("greedy\ngready\n")
    command = ["demos", action, "--population", f"@{tmp_path / 'mine.txt'}", "--map", "Simple", "--ticks", "5"]
    assert main([*command, "--out", str(tmp_path / "out")]) == 2
    assert "unknown agent 'gready'; did you mean greedy?" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "said", ["person:name=C03,stick=8", "late:agent=person:name=C04;stick=8", "person:stick=8,name=C05"]
)
def test_people_of_c_with_other_habits_or_hands_are_for_tests_too(said: str, tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text(f"idle\n{said}\n")
    assert caution([f"@{tmp_path / 'mine.txt'}"]) == caution([said]) == caution(["C"])


def test_people_of_c_on_a_list_are_for_tests_too(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("idle\nperson:name=C07\n")
    assert caution([f"@{tmp_path / 'mine.txt'}"]) == caution(["C"])
    with pytest.raises(DataError, match="people of C are for tests and never trained with"):
        check_partners(f"@{tmp_path / 'mine.txt'}")
    with pytest.raises(DataError, match="--partners C: people of C"):
        check_partners("C")


IDS = ["idle", "greedy:order=heavy"]
NOBODY: list[str] = []


@pytest.fixture
def package(monkeypatch: pytest.MonkeyPatch) -> None:
    """An installed package with families, one of which has a name of ours."""
    values = {"mine": "IDS", "empty": "NOBODY", "gone": "GONE", "greedy": "IDS"}
    entries = {name: EntryPoint(name, f"{__name__}:{value}", "movingout.families") for name, value in values.items()}
    monkeypatch.setattr("movingout.agents.partners.families.installed", lambda _: entries)


@pytest.mark.usefixtures("package")
def test_a_package_adds_a_family(capsys: pytest.CaptureFixture[str]) -> None:
    assert [(one.name, one.agent_id) for one in group("family:mine")] == [("mine01", IDS[0]), ("mine02", IDS[1])]
    assert (
        to_try("family:mine") == tuple(IDS) and len(group("family:greedy")) == MEMBERS == len(to_try("families")) * 20
    )
    assert not any(one.name.startswith("mine") for one in group("families"))  # which means the same everywhere
    assert main(["demos", "people"]) == 0
    printed, told = capsys.readouterr()
    assert "family:mine: of the package" in printed and "mine02  greedy:order=heavy" in printed
    assert [line.partition(" of ")[0] for line in told.splitlines()] == [
        "movingout: left out: the family 'empty'",
        "movingout: left out: cannot load the family 'gone'",
    ]


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("import sys\nsys.exit('no licence')\n", "SystemExit: no licence"),
        ("raise KeyboardInterrupt\n", "KeyboardInterrupt"),
    ],
)
def test_a_package_that_ends_the_program_is_named(
    code: str, said: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "ending_families.py").write_text(code)
    monkeypatch.delitem(sys.modules, "ending_families", raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    entry = EntryPoint("ending", "ending_families:IDS", "movingout.families")
    monkeypatch.setattr("movingout.agents.partners.families.installed", lambda _: {"ending": entry})
    with pytest.raises(AgentError, match=f"cannot load the family 'ending' of ending_families: {said}"):
        group("family:ending")


@pytest.mark.usefixtures("package")
@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("family:empty", "NOBODY is no list of agent ids"),
        ("family:gone", "cannot load the family 'gone' of .*AttributeError"),
        ("family:mien", "did you mean mine"),
        ("families:without-mine", "family mine is of the package .* and no part of `families`"),
    ],
)
def test_a_family_of_a_package_that_cannot_be_used_is_refused(name: str, sentence: str) -> None:
    with pytest.raises(AgentError, match=sentence):
        group(name)
