"""The templates of studies, the published one among them."""

import pytest

from movingout.study.design.allocation import assign
from movingout.study.design.definition import Study
from movingout.study.design.study_file import parse_study
from movingout.study.design.templates import template_names, template_text
from movingout.study.errors import StudyError


@pytest.mark.parametrize("name", template_names())
def test_every_template_is_a_valid_study_whose_comments_explain_it(name: str) -> None:
    text = template_text(name)
    assert isinstance(parse_study(text, name), Study)
    assert text.count("#") > 15
    assert all(len(line) <= 120 for line in text.splitlines())


def test_the_published_study_is_the_papers() -> None:
    study = parse_study(template_text("human_study_as_published"))
    assert study.participants == 32
    assert [(block.seats, len(block.partners), len(block.maps), block.limit_ticks) for block in study.blocks] == [
        ("red", 2, 12, 500),
        ("blue", 2, 12, 500),
    ]
    assert {name for block in study.blocks for name in block.after_partner} == {"movingout-paper-nine"}


def test_the_papers_study_has_two_models_in_both_seats_that_choose_as_in_the_paper() -> None:
    study = parse_study(template_text("paper"))
    (block,) = study.blocks
    assert (study.participants, block.seats, len(block.maps), block.limit_ticks) == (32, "both", 12, 500)
    assert [one.agent for one in study.partners] == ["dp@all:lag=1", "bass@all:score=nfd,sampling=4,lag=1"]
    turns = [(turn.map, turn.seat) for visit in assign(study, 0).visits for turn in visit.turns]
    assert len(turns) == 48 and {seat for _, seat in turns} == {0, 1}


def test_the_papers_second_challenge_has_items_that_its_models_have_not_learned_from() -> None:
    study, first = parse_study(template_text("paper_challenge_2")), parse_study(template_text("paper"))
    (block,), (same,) = study.blocks, first.blocks
    assert (block.challenge, block.split, block.variants) == (2, "evaluation", "shared")
    alike = same.model_copy(update={"challenge": 2})
    assert (study.participants, block) == (first.participants, alike)
    assert [one.agent for one in study.partners] == ["dp@c2:lag=1", "bass@c2:score=nfd,sampling=4,lag=1"]
    seeds = [
        {turn.map: turn.variant_seed for visit in assign(study, slot).visits for turn in visit.turns} for slot in (0, 1)
    ]
    assert len(seeds[0]) == 12 and None not in seeds[0].values() and seeds[0] == seeds[1]


def test_an_unknown_template_is_answered_with_the_known_ones() -> None:
    with pytest.raises(
        StudyError,
        match="known: agent_survey, collect, human_study, human_study_as_published, paper, paper_challenge_2",
    ):
        template_text("nope")
    with pytest.raises(StudyError, match="did you mean paper\\?"):
        template_text("papr")


@pytest.mark.parametrize("name", template_names())
def test_ready_made_studies_practise_with_the_tutorial(name: str) -> None:
    practice = parse_study(template_text(name)).practice
    assert practice is not None and practice.tutorial
