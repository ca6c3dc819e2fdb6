"""Seats and partners cross within each block; studies that have begun keep the rule that they began by."""

from collections import Counter
from hashlib import sha256
from pathlib import Path

import pytest

from movingout.recordings.report.words import Phrase, Words
from movingout.server.cli import main
from movingout.study.analysis.design_flags import design_flags
from movingout.study.analysis.results import Flag
from movingout.study.analysis.tables import LANGUAGE_FILES
from movingout.study.commands.data import earlier_seats_told
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.allocation import assign, cells
from movingout.study.design.definition import ALLOCATION, Study
from movingout.study.design.review import review
from movingout.study.design.study_file import parse_study
from movingout.study.design.templates import template_names, template_text
from movingout.study.store.clock import now_ms
from movingout.study.store.frozen_study import freeze_study, frozen_study
from movingout.study.store.tables import study as study_table
from tests.study.filled import fill
from tests.study.support import TEXT, agree, open_store, study

HEAD = """\
format: 1
id: blocks
title: Blocks
participants: 24
consent: {version: "1", text: We record how you play.}
partners: [{id: a, agent: scripted}, {id: b, agent: greedy}, {id: c, agent: porter}]
debrief: {text: They were programs.}
blocks:
"""
BLOCK = "  - {id: block-%d, partners: [%s], maps: [%s], seats: %s}\n"
ONE, TWO, THREE = "Simple", "Simple, HandOff", "Simple, HandOff, LeftRight"
TWICE = (("a, b", THREE, "alternate"), ("a, b", THREE, "alternate"))
DESIGNS = (TWICE, TWICE * 2, (("a, b, c", TWO, "both"), ("a, b", ONE, "alternate"), ("a, b, c", THREE, "alternate")))
EARLIER = {1: "d8dca1e0", 2: "c7bef761"}  # of the orders that TWICE was drawn by before there was another rule


def of_blocks(blocks: tuple[tuple[str, str, str], ...]) -> Study:
    return parse_study(HEAD + "".join(BLOCK % (number, *block) for number, block in enumerate(blocks)))


def seats(of: Study, block: str, slots: int) -> Counter[tuple[str, int]]:
    """How often each partner is met in each seat."""
    visits = [visit for slot in range(slots) for visit in assign(of, slot).visits if visit.block == block]
    return Counter((visit.partner, turn.seat) for visit in visits for turn in visit.turns)


@pytest.mark.parametrize("blocks", DESIGNS)
def test_in_every_block_each_partner_is_met_in_both_seats_as_often(blocks: tuple[tuple[str, str, str], ...]) -> None:
    of = of_blocks(blocks)
    for block in of.blocks:
        assert len(set(seats(of, block.id, cells(of)).values())) == 1
        for slots in range(1, 40):  # whenever the study stops
            blue = [seats(of, block.id, slots)[partner, 0] for partner in block.partners]
            assert max(blue) - min(blue) <= 2


def test_whoever_begins_a_block_with_one_partner_begins_the_next_one_with_another() -> None:
    of = of_blocks(TWICE)
    for slot in range(12):
        first, second = (visit.partner for visit in assign(of, slot).visits[::2])
        assert first != second


@pytest.mark.parametrize("name", template_names())
def test_the_first_block_is_the_same_by_the_first_two_rules(name: str) -> None:
    of = parse_study(template_text(name))
    for slot in range(60):
        first, second = (assign(of.allocated_by(rule), slot).visits for rule in (1, 2))
        assert first[0] == second[0]


def test_check_warns_where_seats_and_partners_go_together_in_a_block() -> None:
    of = of_blocks(TWICE)
    assert not [one for one in review(of).warnings if "confounded" in one]
    (warning,) = [one for one in review(of.allocated_by(1)).warnings if "role and model are confounded" in one]
    assert warning.startswith(
        "block block-1: role and model are confounded: participants play in blue and in red with a 48 and 24, "
        "b 24 and 48 rounds"
    )


def test_on_the_page_of_a_report_it_is_a_quality_flag() -> None:
    of = of_blocks(TWICE)
    assert not list(design_flags(of, blinded=False))
    role, of_map = design_flags(of.allocated_by(1), blinded=False)
    assert role == Flag("", "block-1", Phrase("study.flag.partners_by_seat", {"counts": "a 48 / 24, b 24 / 48"}))
    assert of_map.reason.values == {"map": "Simple", "partner": "a", "blue": 16, "red": 8}
    role, of_map = design_flags(of.allocated_by(1), blinded=True)
    assert role.reason.values == {"counts": "Partner B 24 / 48, Partner C 48 / 24"}
    german = Words("de", (LANGUAGE_FILES,)).phrase(of_map.reason)
    assert "Simple mit Partner C wird in Blau und in Rot 16- und 8-mal gespielt" in german


def test_a_server_says_it_at_its_start_once_somebody_has_come(tmp_path: Path) -> None:
    text = HEAD + "".join(BLOCK % (number, *block) for number, block in enumerate(TWICE))
    folder, store, _ = fill(tmp_path, of_blocks(TWICE), text, 0)
    told = "block block-1: role and model are confounded: participants play in blue and in red with a 48 and 24"
    assert earlier_seats_told(folder) == []
    with store.database.write() as connection:
        connection.execute(study_table.update().values(allocation=1))
    assert earlier_seats_told(folder) == [], "it begins by the newest rule"
    store.arrive("P1", "en")
    (role, _) = earlier_seats_told(folder)
    assert role.startswith(told)


@pytest.mark.slow
def test_exports_and_reports_of_a_study_begun_by_the_first_rule_say_it_too(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`check` reads the file, of which a study that begins now is drawn by the newest rule."""
    of, file = of_blocks(TWICE), tmp_path / "study.yaml"
    file.write_text(HEAD + "".join(BLOCK % (number, *block) for number, block in enumerate(TWICE)))
    _, store, _ = fill(tmp_path / "data", of, file.read_text(), 2, clock=now_ms)
    told = "warning: block block-1: role and model are confounded: participants play in blue and in red with "
    for rule in (ALLOCATION, 1):
        with store.database.write() as connection:
            connection.execute(study_table.update().values(allocation=rule))
        for command in (["export", "--formats", "csv", "--no-training"], ["report"], ["report", "--blinded"]):
            out = str(tmp_path / f"{'-'.join(command)} {rule}")
            assert main(["study", *command, str(file), "--data", str(tmp_path / "data"), "-o", out]) == 0
            said = told + ("Partner " if "--blinded" in command else "a 48 and 24")
            assert (said in capsys.readouterr().out) == (rule == 1)
            flags = Path(out, "flags.csv").read_text("utf-8-sig") if "report" in command else ""
            assert ('–,block-1,"partner and seat go together' in flags) == (rule == 1 and "report" in command)


def test_a_study_that_has_begun_by_the_first_rule_is_drawn_by_it_to_its_end(place: Path | str, tmp_path: Path) -> None:
    store = open_store(place)
    assert frozen_study(store).allocation == ALLOCATION
    with store.database.write() as connection:
        connection.execute(study_table.update().values(allocation=1))
    freeze_study(store, "agent-survey", TEXT, {}, {"scripted": ""})
    assert frozen_study(store).allocation == ALLOCATION, "nobody had come"
    with store.database.write() as connection:
        connection.execute(study_table.update().values(allocation=1))
    agree(store, ["P1"])
    freeze_study(store, "agent-survey", TEXT, {}, {"scripted": ""})
    assert frozen_study(store).allocation == 1
    assert StudyFolder(study(), tmp_path).as_frozen(store, tmp_path).study.allocation == 1


@pytest.mark.parametrize("rule", EARLIER)
def test_earlier_rules_stay_what_they_were(rule: int) -> None:
    of = of_blocks(TWICE).allocated_by(rule)
    drawn = [(v.partner, t.map, t.seat) for slot in range(48) for v in assign(of, slot).visits for t in v.turns]
    assert sha256(repr(drawn).encode()).hexdigest()[:8] == EARLIER[rule]
