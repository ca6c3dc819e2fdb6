"""`movingout study` on the command line."""

import json
from pathlib import Path

import pytest

from movingout.server.cli import main
from movingout.study.design.templates import template_names, template_text


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
    assert len(document["orders"]) == document["participants"] // (2 if name == "collect" else 1)


def test_the_page_of_check_says_duration_pay_orders_and_blanks(capsys: pytest.CaptureFixture[str]) -> None:
    main(["study", "check", "study/templates/collect.yaml"])
    page = capsys.readouterr().out
    assert "At most 69 minutes" in page
    assert "Pay: USD 17.17 each, USD 618.12 for all." in page
    assert "missing: the consent has a blank to fill in: [name and address of the investigator]" in page
    assert "not ready: 3 blanks to fill in, 2 warnings" in page


def check_warnings(path: str, capsys: pytest.CaptureFixture[str]) -> str:
    main(["study", "check", path, "--json"])
    return "\n".join(json.loads(capsys.readouterr().out)["warnings"])


def test_check_warns_that_role_and_model_are_confounded_in_the_published_design_and_only_there(
    capsys: pytest.CaptureFixture[str],
) -> None:
    sentence = "role and model are confounded: participants meet"
    published = check_warnings("study/templates/human_study_as_published.yaml", capsys)
    assert sentence in published and "only as red and " in published
    for name in ("human_study", "collect", "agent_survey"):
        assert sentence not in check_warnings(f"study/templates/{name}.yaml", capsys)


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


def test_the_recommended_study_has_no_weakness_of_design(capsys: pytest.CaptureFixture[str]) -> None:
    found = check_warnings("study/templates/human_study.yaml", capsys).splitlines()
    assert [line.partition(" ")[0] for line in found] == ["protocol"]  # its number


def test_a_missing_model_is_named_and_the_check_fails(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(template_text("agent_survey").replace("agent: scripted}\n\nb", "agent: nobody@all}\n\nb"))
    assert main(["study", "check", str(file)]) == 1
    page = capsys.readouterr().out
    assert "missing: unknown agent 'nobody@all'" in page and "not ready: 1 agent missing" in page


def test_faults_are_listed_with_their_lines_and_the_exit_code_is_two(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(template_text("agent_survey").replace("HandOff,", "HandOf,"))
    assert main(["study", "check", str(file)]) == 2
    assert "blocks[0].maps: unknown map 'HandOf'" in capsys.readouterr().err


def test_a_file_that_exists_is_never_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("mine")
    assert main(["study", "new", "-o", str(file)]) == 2
    assert "is not overwritten" in capsys.readouterr().err
    assert file.read_text() == "mine"
