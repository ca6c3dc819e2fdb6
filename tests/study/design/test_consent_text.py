"""The consent says what the study file says: places are filled, blanks and other numbers are found."""

import json
from pathlib import Path

import pytest

from movingout.server.cli import main
from movingout.study.design.allocation import letters
from movingout.study.design.consent_text import contradictions, filled, unfilled
from movingout.study.design.review import review
from movingout.study.design.study_file import parse_study
from movingout.study.design.templates import template_names, template_text
from tests.study.design.small_study import SMALL

PAID = SMALL.replace(
    "participants: 4",
    "participants: 4\nprotocol: IRB-7\nminutes: 30\npay: {currency: EUR, per_hour: 12.5, maximum: 20}",
)


def consent(text: str, study: str = PAID) -> str:
    return study.replace("text: We record how you play.", f"text: {json.dumps(text)}")


def test_places_are_filled_with_the_fields_in_the_way_of_the_language() -> None:
    text = "{minutes} minutes, {pay.per_hour} per hour, at most {pay.maximum}, protocol {protocol}, {else}"
    study = parse_study(consent(text))
    assert filled(study, study.consent.text, "en") == (
        "30 minutes, 12.50 EUR per hour, at most 20 EUR, protocol IRB-7, {else}"
    )
    assert filled(study, study.consent.text, "de-AT").startswith("30 minutes, 12,50 EUR per hour, at most 20 EUR")


def test_blanks_and_places_without_a_value_are_named() -> None:
    text = "Ask [name and\n address] or [us](https://example.org); {pay.hourly}, \\[sic], {protocol}"
    assert unfilled(parse_study(consent(text, SMALL))) == (
        "the consent has a blank to fill in: [name and address]",
        "the consent has {pay.hourly}, which is no place; places are "
        "{minutes}, {protocol}, {pay.per_hour}, {pay.maximum}",
        "the consent has {protocol}, and the file has no protocol",
    )
    assert unfilled(parse_study(consent("{minutes} minutes for {pay.per_hour}"))) == ()


def test_the_debriefing_says_which_letter_was_which_partner_and_the_consent_cannot() -> None:
    study = parse_study(template_text("human_study"))
    assert study.debrief is not None
    found = filled(study, study.debrief.text, "en")
    told = [f"{shown}: {name}" for name, shown in letters(study).items()]
    assert f"influence you: {', '.join(sorted(told))}. We compare" in " ".join(found.split())
    assert not any("{partners}" in sentence for sentence in unfilled(study))
    assert "{partners}, which is no place" in unfilled(parse_study(consent("Played with {partners}")))[0]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("It takes about 75 minutes.", "the consent says 75 minutes, and `minutes` is 30"),
        ("Es dauert etwa 75 Minuten.", "the consent says 75 minutes, and `minutes` is 30"),
        ("You are paid 20 USD per hour.", "the consent says 20 USD, and `pay` has 12.5 EUR, 20 EUR"),
        ("You are paid $20 per hour.", "the consent says 20 USD, and `pay` has 12.5 EUR, 20 EUR"),
        ("Sie bekommen 12,50 € pro Stunde, höchstens 25 €.", "the consent says 25 EUR, and `pay` has 12.5 EUR"),
        ("You are paid EUR 1,250.50 per hour.", "the consent says 1250.5 EUR, and `pay` has 12.5 EUR, 20 EUR"),
        ("Sie bekommen 12.000 EUR.", "the consent says 12000 EUR, and `pay` has 12.5 EUR, 20 EUR"),
        ("Sie bekommen 12\u00a0000 EUR.", "the consent says 12000 EUR, and `pay` has 12.5 EUR, 20 EUR"),
        ("Raum 12 100 EUR werden bezahlt.", "the consent says 100 EUR, and `pay` has 12.5 EUR, 20 EUR"),
        ("You are paid CA$20 per hour.", "the consent says 20 CAD, and `pay` has 12.5 EUR, 20 EUR"),
        ("You are paid AUD $20 or $20 NZD.", "the consent says 20 AUD, 20 NZD, and `pay` has 12.5 EUR, 20 EUR"),
        ("{pay.per_hour} per hour, 30 EUR at most.", "the consent says 30 EUR, and `pay` has 12.5 EUR, 20 EUR"),
        ("{pay.per_hour} per hour, 5 EUR for travel.", "the consent says 5 EUR, and `pay` has 12.5 EUR, 20 EUR"),
        ("You are paid 12.5 EUR 20 USD.", "the consent says 20 USD, and `pay` has 12.5 EUR, 20 EUR"),
    ],
)
def test_a_number_that_differs_from_the_file_is_named(text: str, said: str) -> None:
    (found,) = contradictions(parse_study(consent(text)))
    assert found.startswith(said)


@pytest.mark.parametrize(
    "text",
    [
        "It takes 30 minutes, of which 5 minutes are practice; ask within 24 hours (45 CFR 46.116).",
        "You are paid 12.50 EUR per hour, at most EUR 20.",
        "It takes {minutes} minutes, with a break of 5 minutes. {pay.per_hour} per hour, at most {pay.maximum}; "
        "5 EUR for travel.",
        "It takes half an hour, with a break of 5 minutes.",
        "Es dauert eine halbe Stunde, davon 5 Minuten Pause.",
        "Es dauert {minutes} Minuten, bezahlt mit {pay.per_hour} je Stunde.",
    ],
)
def test_numbers_that_agree_with_the_file_are_no_contradiction(text: str) -> None:
    assert contradictions(parse_study(consent(text))) == ()


@pytest.mark.parametrize(
    ("minutes", "text"),
    [
        (60, "It takes one hour, with a break of 5 minutes."),
        (60, "It takes 1 h, of which 5 min are practice."),
        (75, "It takes 1 hour and 15 minutes."),
        (90, "It takes 1.5 hours, one and a half  hours, with a break of 5 minutes."),
        (90, "Es dauert 1,5 Stunden, mit 5 Minuten Pause."),
        (120, "A two-hour session with a break of 5 minutes."),
    ],
)
def test_the_duration_may_stand_in_hours(minutes: int, text: str) -> None:
    study = PAID.replace("minutes: 30", f"minutes: {minutes}")
    assert contradictions(parse_study(consent(text, study))) == ()
    (found,) = contradictions(parse_study(consent(text, PAID.replace("minutes: 30", "minutes: 40"))))
    assert found.endswith("and `minutes` is 40; {minutes} is always right")


@pytest.mark.parametrize(
    ("pay", "text"),
    [
        ("{currency: JPY, per_hour: 1500, maximum: 12000}", "1,500 JPY per hour, at most JPY 12 000; 1.500 JPY"),
        ("{currency: AUD, per_hour: 20}", "You are paid $20 per hour, AU$20, $20 AUD, AUD $20 or 20 $."),
        ("{currency: CAD, per_hour: 20.5}", "You are paid CA$20.50 per hour, C$20.50 or $20.50."),
        ("{currency: USD, per_hour: 1234.5}", "You are paid US$1,234.50 per hour, USD$1234.5; R$7 is no dollar."),
        ("{currency: CHF, per_hour: 1500}", "You are paid CHF 1'500 per hour."),
        ("{currency: USD, per_hour: 100}", "Come to room 12 100 USD per hour are paid, USD 100 250 people."),
        ("{currency: USD, per_hour: 456}", "Grant 123 456 USD per hour."),
        ("{currency: JPY, per_hour: 1234567.5}", "1 234 567.50 JPY, JPY 1\u00a0234\u202f567.5"),
    ],
)
def test_thousands_and_dollars_are_read_as_people_write_them(pay: str, text: str) -> None:
    study = PAID.replace("{currency: EUR, per_hour: 12.5, maximum: 20}", pay)
    assert pay in study and contradictions(parse_study(consent(text, study))) == ()


def test_a_promise_of_pay_without_pay_is_a_contradiction() -> None:
    (found,) = contradictions(parse_study(consent("You are paid 20 USD per hour.", SMALL)))
    assert found == "the consent promises 20 USD, and the file has no `pay`"


@pytest.mark.parametrize(
    ("codes", "text", "warned"),
    [
        ("{done: C1AB2CD3}", "You can ask for deletion later, with the code you are shown at the end.", True),
        ("{done: C1AB2CD3}", "Sie können die Löschung auch später verlangen, mit dem Code vom Ende.", True),
        ("{done: C1AB2CD3}", "Data have a random code. Ask for deletion later with your Prolific ID.", False),
        ("{done: C1AB2CD3}", "Was gespeichert ist, bleibt.", False),
        ("unique", "You can ask for deletion later, with the code you are shown at the end.", False),
    ],
)
def test_a_later_deletion_with_a_code_that_all_have_is_warned_of(codes: str, text: str, warned: bool) -> None:
    found = review(parse_study(consent(text) + f"codes: {codes}\n")).warnings
    assert any("let it ask for the ID on the platform" in one for one in found) == warned


def test_check_fails_on_the_contradiction_and_says_both_numbers(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(consent("You are paid 20 USD per hour. It takes 75 minutes."), encoding="utf-8")
    assert main(["study", "check", str(file)]) == 1
    page = capsys.readouterr().out
    assert "wrong: the consent says 75 minutes, and `minutes` is 30" in page
    assert "not ready: 2 numbers wrong" in page


@pytest.mark.parametrize("name", template_names())
def test_a_template_contradicts_itself_in_nothing_and_asks_for_what_only_its_user_knows(name: str) -> None:
    found = review(parse_study(template_text(name)))
    assert found.contradictions == ()
    assert [one.partition(": ")[2] or one for one in found.unfilled] == [
        "[name and address of the investigator]",
        "[review board and its address]",
        "the consent has {protocol}, and the file has no protocol",
    ]
