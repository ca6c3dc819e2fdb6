"""`movingout study` on the command line."""

import json
import re
from pathlib import Path

import pytest

from movingout.server.cli import main
from movingout.study.design.study_file import read_study
from movingout.study.design.templates import template_names, template_text
from tests.study.design.small_study import SMALL


@pytest.mark.parametrize("name", template_names())
def test_a_new_study_is_written_and_checked(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["study", "new", "--template", name]) == 0
    page = capsys.readouterr().out
    assert "[name and address of the investigator]" in page and "the file has no protocol" in page
    assert (tmp_path / f"{name}.yaml").read_text(encoding="utf-8") == template_text(name)
    code = main(["study", "check", f"{name}.yaml", "--json"])
    document = json.loads(capsys.readouterr().out)
    assert code == 1 and document["unfilled"], "a template is not ready before its blanks are filled in"
    assert document["untranslated"] == document["contradictions"] == []
    assert document["timeline"][0]["step"] == "consent"
    assert document["partners"].get("Partner A", {"id": "", "agent": ""}).keys() == {"id", "agent"}
    assert {visit["partner"] for order in document["orders"] for visit in order["visits"]} - {""} <= {
        *document["partners"]
    }
    assert len(document["orders"]) == document["participants"] // (2 if name == "collect" else 1)


@pytest.mark.parametrize("name", template_names())
@pytest.mark.parametrize("languages", [["en", "de"], ["de"]])
def test_a_new_study_speaks_the_languages_that_it_is_to_offer(
    name: str, languages: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "study.yaml"
    assert main(["study", "new", "--template", name, "--languages", *languages, "-o", str(file)]) == 0
    assert "[Name und Anschrift der Studienleitung]" in capsys.readouterr().out
    main(["study", "check", str(file), "--json"])
    document = json.loads(capsys.readouterr().out)
    assert document["untranslated"] == document["contradictions"] == []
    study = read_study(file)
    assert list(study.languages) == languages
    assert list(study.title.root) == list(study.consent.text.root) == languages
    assert all(list(box.text.root) == languages for box in study.consent.boxes)


def test_a_language_without_texts_is_refused_and_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["study", "new", "--languages", "en", "fr", "-o", str(tmp_path / "study.yaml")]) != 0
    assert "templates have no texts in fr; they have en, de" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def written(name: str, folder: Path) -> str:
    file = folder / f"{name}.yaml"
    file.write_text(template_text(name), encoding="utf-8")
    return str(file)


def test_the_page_of_check_says_duration_pay_orders_and_blanks(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["study", "check", written("collect", tmp_path)])
    page = capsys.readouterr().out
    assert "At most 67 minutes" in page
    assert "Pay: USD 16.67 each, USD 600.12 for all." in page
    assert "missing: the consent has a blank to fill in: [name and address of the investigator]" in page
    assert "not ready: 3 blanks to fill in, 2 warnings" in page


def check_warnings(path: str, capsys: pytest.CaptureFixture[str]) -> str:
    main(["study", "check", path, "--json"])
    return "\n".join(json.loads(capsys.readouterr().out)["warnings"])


def test_check_warns_that_role_and_model_are_confounded_in_the_published_design_and_only_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sentence = "role and model are confounded: participants meet"
    published = check_warnings(written("human_study_as_published", tmp_path), capsys)
    assert sentence in published and "only as red and " in published
    for name in ("human_study", "collect", "agent_survey", "paper", "paper_challenge_2"):
        assert sentence not in check_warnings(written(name, tmp_path), capsys)


def test_check_says_which_partners_take_no_notice_of_pings_and_where_only_some_blocks_have_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "study.yaml"
    text = template_text("human_study").replace("    challenge: 1 ", "    pings: on\n    challenge: 1 ")
    file.write_text(text)
    found = check_warnings(str(file), capsys)
    assert "do not answer them: dp@all, bass@all, mlp@all, gru@all (scripted does)" in found
    assert "confounded" not in found
    second = "  - {id: again, partners: [dp, bass, mlp, gru], maps: all}\n\nquestionnaires:"
    file.write_text(text.replace("\nquestionnaires:", second, 1))
    assert "pings are on in play only" in check_warnings(str(file), capsys)


def test_the_recommended_study_has_no_weakness_of_design(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = check_warnings(written("human_study", tmp_path), capsys).splitlines()
    assert [line.partition(" ")[0] for line in found] == ["protocol"]  # its number


def test_check_says_which_answer_an_attention_item_expects(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "study.yaml"
    choice = "{id: third, kind: choice, text: Please choose 3., options: ['1', '2', '3', '[4]'], expected: 3}"
    file.write_text(SMALL.replace("    items:\n", f"    items:\n      - {choice}\n"), encoding="utf-8")
    main(["study", "check", str(file)])
    page = capsys.readouterr().out.splitlines()
    assert [line for line in page if line.startswith("attention")] == [
        "attention item 'third' of short expects 3, the option '[4]'",
        "attention item 'attention' of short expects 2",
    ]
    main(["study", "check", str(file), "--json"])
    assert len(json.loads(capsys.readouterr().out)["attention"]) == 2


BROKEN = """
class Broken:
    def __init__(self):
        raise OSError("weights.pt is not there")
"""


def test_an_agent_of_ones_own_that_cannot_be_made_is_told_by_check_and_not_in_a_round(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "my_agent.py").write_text(BROKEN)
    monkeypatch.chdir(tmp_path)
    file = Path(written("human_study", tmp_path))
    file.write_text(file.read_text(encoding="utf-8").replace("bass@all", "my_agent:Broken"), encoding="utf-8")
    assert main(["study", "check", str(file), "--json"]) == 1
    (sentence,) = json.loads(capsys.readouterr().out)["missing"]
    assert "my_agent:Broken" in sentence and "weights.pt is not there (my_agent.py, line 4)" in sentence


ONE_MAP = """
class OneMap:
    def reset(self, episode):
        if episode.map.name != "FourCorners":
            raise ValueError(f"I know FourCorners, not {episode.map.name}")

    def act(self, observation):
        return [[0.0, 1.0, 0.0, 0.0]]
"""


@pytest.mark.slow
def test_an_agent_of_ones_own_for_some_maps_is_tried_on_one_that_it_is_met_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "my_agent.py").write_text(ONE_MAP)
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "study.yaml"
    text = template_text("agent_survey").replace("agent: scripted}\n\nb", "agent: 'my_agent:OneMap'}\n\nb")
    for the_map, sentences in (("HandOff", 1), ("FourCorners", 0)):
        file.write_text(re.sub(r"maps: \[.*\]", f"maps: [{the_map}]", text), encoding="utf-8")
        main(["study", "check", str(file), "--json"])
        assert len(json.loads(capsys.readouterr().out)["missing"]) == sentences


@pytest.mark.parametrize("agent", ["people", "dp@all:execute", "late:agent=my_agent:Nope"])
def test_an_agent_that_cannot_be_is_one_sentence_of_the_whole_report(
    agent: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = Path(written("human_study", tmp_path))
    text = file.read_text(encoding="utf-8").replace("agent: bass@all", f"agent: '{agent}'")
    file.write_text(text, encoding="utf-8")
    assert main(["study", "check", str(file), "--json"]) == 1
    document = json.loads(capsys.readouterr().out)
    assert len(document["missing"]) == 1 and document["timeline"]


def test_a_missing_model_is_named_and_the_check_fails(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(template_text("agent_survey").replace("agent: scripted}\n\nb", "agent: nobody@all}\n\nb"))
    assert main(["study", "check", str(file)]) == 1
    page = capsys.readouterr().out
    assert "missing: unknown agent 'nobody@all'" in page and "not ready: 1 agent that cannot play" in page


def test_an_agent_with_options_that_cannot_be_is_named_before_any_participant_meets_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(template_text("agent_survey").replace("agent: scripted}\n\nb", "agent: 'bass@any:partner=x'}\n\nb"))
    assert main(["study", "check", str(file)]) == 1
    page = capsys.readouterr().out
    assert (
        "missing: bass@any: simulator=" in page
        and "not engine, x" in page
        and "not ready: 1 agent that cannot play" in page
    )


def test_faults_are_listed_with_their_lines_and_the_exit_code_is_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(template_text("agent_survey").replace("HandOff,", "HandOf,"))
    assert main(["study", "check", str(file)]) == 1
    assert "blocks[0].maps: unknown map 'HandOf'" in capsys.readouterr().err
    assert main(["study", "check", str(file), "--json"]) == 1
    document = json.loads(capsys.readouterr().out)
    (fault,) = document["faults"]
    assert not document["ready"] and fault["path"] == "blocks[0].maps" and fault["line"] > 1
    assert main(["study", "check", str(tmp_path / "none.yaml")]) == 2


def test_the_next_command_can_be_copied(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["study", "new", "-o", str(tmp_path / "my study.yaml")]) == 0
    assert f"movingout study check '{tmp_path / 'my study.yaml'}'" in capsys.readouterr().out


def test_a_file_that_exists_is_never_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("mine")
    assert main(["study", "new", "-o", str(file)]) == 2
    assert "is not overwritten" in capsys.readouterr().err
    assert file.read_text() == "mine"
