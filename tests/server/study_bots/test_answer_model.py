"""Answers of simulated participants fit their questions."""

from random import Random

from movingout.server.study_bots.answer_model import AnswerModel
from movingout.study.design.instruments import instrument, instrument_names


def test_every_answer_is_one_that_the_question_takes() -> None:
    answer_model = AnswerModel(Random(1))
    for name in instrument_names():
        questionnaire = instrument(name)
        for item in questionnaire.items * 20:
            value, text = answer_model.answer(item.as_json(), "Partner A")
            questionnaire.check_answer(item.id, value, text)


def test_the_same_seed_gives_the_same_answers_and_another_one_others() -> None:
    items = [item.as_json() for item in instrument("movingout-paper-nine").items]
    drawn = [[AnswerModel(Random(seed)).answer(item, "") for item in items] for seed in (1, 1, 2)]
    assert drawn[0] == drawn[1] != drawn[2]


def test_a_partner_that_is_liked_is_liked_in_all_questions() -> None:
    items = [item.as_json() for item in instrument("movingout-paper-nine").items if item.kind == "likert7"] * 10
    means = []
    for seed in range(30):
        answer_model = AnswerModel(Random(seed))
        values = [value for item in items if (value := answer_model.answer(item, "Partner A")[0]) > 0]
        means.append(sum(values) / len(values))
    assert max(means) - min(means) > 1.5
