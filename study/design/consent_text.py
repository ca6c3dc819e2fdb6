"""Places in the consent that are filled from the study file, and whether its text says the same as the file.

`{minutes}`, `{protocol}`, `{pay.per_hour}` and `{pay.maximum}` stand for these fields, amounts with their currency; in
the debriefing `{partners}` says which letter was which partner.
"""

import re
from collections.abc import Iterable, Iterator
from typing import Final

from movingout.recordings.report.words import Words
from movingout.study.design.allocation import letters
from movingout.study.design.definition import Study
from movingout.study.design.localized_text import LocalizedText
from movingout.study.design.markdown import unseen_pictures

PLACES: Final = ("minutes", "protocol", "pay.per_hour", "pay.maximum")
PARTNERS: Final = "partners"  # would unblind anywhere but in the debriefing
DEBRIEFING: Final = "the debriefing"
_PLACE = re.compile(r"\{([a-z][a-z_.]*)\}")
_BLANK = re.compile(r"(?<!\\)\[[^\]]+\](?![(\[])")  # [number], and not a link; \[ is a bracket that stays
_CODE = re.compile(r"\bcode\b", re.IGNORECASE)  # in German, too
_PLATFORM_ID = re.compile(r"\bID\b")
_SIGNS: Final = {"€": "EUR", "£": "GBP"}
_SIGN = r"(?<![A-Za-z])[A-Z]{0,3}\$|[€£]"  # also US$, CA$, ...
_DOLLARS: Final = ("USD", "AUD", "CAD", "HKD", "MXN", "NZD", "SGD", "TWD")  # all written with $
_CURRENCIES: Final = ("AUD", "CAD", "CHF", "CNY", "EUR", "GBP", "JPY", "USD")
_THOUSANDS = r"\d{1,3}(?:[.,'’\u00a0\u2009\u202f]\d{3})+"  # 1,500 or 1.500, or with a space that breaks no line
_MINUTES = re.compile(r"\b(\d+)[\s-]*(?:minutes?|Minuten?|min)\b")
_HOURS_IN_WORDS: Final = {
    "half an": 0.5, "a": 1, "an": 1, "one": 1, "one and a half": 1.5, "two": 2, "three": 3,
    "halbe": 0.5, "eine": 1, "einer": 1, "anderthalb": 1.5, "eineinhalb": 1.5, "zwei": 2, "drei": 3,
}  # fmt: skip
_HOURS = re.compile(
    rf"(?<![\d.,])\b(\d+(?:[.,]\d+)?|{'|'.join(sorted(_HOURS_IN_WORDS, key=len, reverse=True)).replace(' ', ' +')})"
    r"[\s-]*(?:hours?|Stunden?|h)\b",
    re.IGNORECASE,
)


def filled(study: Study, text: LocalizedText, language: str) -> str:
    """The text in a language with the values of the study; a place without a value stays as it is."""

    def value(match: re.Match[str]) -> str:
        return _value(study, match[1], language) or match[0]

    return _PLACE.sub(value, text.text(language))


def unfilled(study: Study) -> tuple[str, ...]:
    """A sentence per blank that participants would read: [brackets], and places that the file has no value for."""
    found = [sentence for where, text in _texts(study) for sentence in _blanks(study, where, text)]
    return tuple(dict.fromkeys(found))


def contradictions(study: Study) -> tuple[str, ...]:
    """A sentence per number in the consent that differs from the field of the file."""
    found = []
    for language in study.consent.text.root:
        text = filled(study, study.consent.text, language)
        found += [*_wrong_minutes(study, text), *_wrong_pay(study, text)]
    return tuple(dict.fromkeys(found))


def shared_code(study: Study) -> Iterator[str]:
    """A sentence where people are to ask for a deletion with a code that others have, too."""
    texts = study.consent.text.root.values()
    if study.codes != "unique" and any(_CODE.search(text) and not _PLATFORM_ID.search(text) for text in texts):
        yield (
            "codes are fixed, so nobody can be found by theirs: where the consent offers a later deletion with the "
            "code, let it ask for the ID on the platform (“with your Prolific ID”), which payments.csv has beside the "
            f"pseudonym for as long as retention.identity says, {study.retention.identity}"
        )


def unseen(study: Study) -> Iterator[str]:
    """A sentence per picture that participants would not see; boxes have no Markdown."""
    shown = [("the consent", study.consent.text)] + ([(DEBRIEFING, study.debrief.text)] if study.debrief else [])
    for where, text in shown:
        for address in dict.fromkeys(address for one in text.root.values() for address in unseen_pictures(one)):
            yield (
                f"{where} has the picture {address[:100]}, which participants' pages do not load: write it into "
                "the text, as ![Logo](data:image/png;base64,...) of up to 70 kB (or jpeg, gif, webp), or leave it out"
            )


def _texts(study: Study) -> Iterator[tuple[str, LocalizedText]]:
    yield "the consent", study.consent.text
    for box in study.consent.boxes:
        yield f"consent box {box.id!r}", box.text
    if study.debrief is not None:
        yield DEBRIEFING, study.debrief.text


def _blanks(study: Study, where: str, text: LocalizedText) -> Iterator[str]:
    places = (*PLACES, PARTNERS) if where == DEBRIEFING else PLACES
    for language, one in text.root.items():
        for blank in _BLANK.findall(one):
            yield f"{where} has a blank to fill in: {' '.join(blank.split())}"
        for place in _PLACE.findall(one):
            if place not in places:
                known = ", ".join(f"{{{name}}}" for name in places)
                yield f"{where} has {{{place}}}, which is no place; places are {known}"
            elif not _value(study, place, language):
                yield f"{where} has {{{place}}}, and the file has no {place}"


def _value(study: Study, place: str, language: str) -> str:
    """Empty where the file has none."""
    pay = study.pay
    if place == "minutes":
        return str(study.minutes)
    if place == "protocol":
        return study.protocol
    if place == PARTNERS:
        return ", ".join(
            f"{shown}: {name}" for shown, name in sorted((two, one) for one, two in letters(study).items())
        )
    if place == "pay.per_hour" and pay is not None:
        return _amount(pay.per_hour, pay.currency, language)
    if place == "pay.maximum" and pay is not None and pay.maximum is not None:
        return _amount(pay.maximum, pay.currency, language)
    return ""


def _amount(value: float, currency: str, language: str) -> str:
    number = f"{value:.0f}" if value == int(value) else f"{value:.2f}"
    return f"{Words(language).decimal(number)} {currency}"


# ---- numbers that differ from the file ----------------------------------------------------------------------------


def _wrong_minutes(study: Study, text: str) -> Iterator[str]:
    """Of several durations one must be the whole, be it in hours: others may be those of practice or a break."""
    said = [int(number) for number in _MINUTES.findall(text)]
    if said and study.minutes not in {*said, *_in_hours(text, said)}:
        listed = ", ".join(str(number) for number in dict.fromkeys(said))
        yield f"the consent says {listed} minutes, and `minutes` is {study.minutes}; {{minutes}} is always right"


def _in_hours(text: str, minutes: Iterable[int]) -> set[float]:
    """The durations in minutes of "one hour" and "1 hour 15 minutes"."""
    words = (" ".join(said.lower().split()) for said in _HOURS.findall(text))
    hours = {60 * (_HOURS_IN_WORDS.get(said) or float(said.replace(",", "."))) for said in words}
    return hours | {hour + more for hour in hours for more in minutes}


def _wrong_pay(study: Study, text: str) -> Iterator[str]:
    """Where all amounts of the file are there, others may stand beside them, as for travel."""
    known = [(study.pay.per_hour, study.pay.currency)] if study.pay else []
    if study.pay and study.pay.maximum is not None:
        known.append((study.pay.maximum, study.pay.currency))
    values = [value for value, _ in known]
    said = list(dict.fromkeys(_amounts(text, study.pay.currency if study.pay else "", values)))
    wrong = [f"{value:g} {currency}" for value, currency in said if (value, currency) not in known]
    if wrong and study.pay is None:
        yield f"the consent promises {', '.join(wrong)}, and the file has no `pay`"
    elif wrong and not {*known} <= {*said}:
        right = ", ".join(f"{value:g} {currency}" for value, currency in known)
        places = " and ".join(f"{{{name}}}" for name in ("pay.per_hour", "pay.maximum")[: len(known)])
        way_out = f"say {places}, then others may stand there, too"
        yield f"the consent says {', '.join(wrong)}, and `pay` has {right}; {way_out}"


def _number(known: Iterable[float]) -> str:
    """A pattern: 1 500 is one number where it is `known`, else two, as in "room 12 100 USD"."""
    spaced = [f"{int(value):,}".replace(",", "[ \u00a0\u2009\u202f]") for value in known if value >= 1000]
    whole = "|".join([*spaced, _THOUSANDS])
    return rf"(?<!\d)(?<!\d[.,])(?P<whole>(?:{whole})(?!\d)|\d+)(?:[.,](?P<cents>\d{{1,2}}))?(?!\d)"


def _amounts(text: str, own: str, known: Iterable[float]) -> Iterator[tuple[float, str]]:
    """Every amount of money: "20 USD", "USD 20", "20 $", "$20", "$20 AUD".

    `own` is the currency of the study, `known` has the amounts of its file.
    """
    code = rf"\b(?:{'|'.join(sorted({*_CURRENCIES, *_DOLLARS, *filter(None, [own])}))})\b"
    behind = rf"(?(sign)(?:\s?(?P<code>{code}))?|\s?(?P<behind>{code}|{_SIGN}))"
    pattern = rf"(?:(?P<before>{code})\s?)?(?:(?P<sign>{_SIGN})\s?)?{_number(known)}(?(before)|{behind})"
    for match in re.finditer(pattern, text):
        unit = next(match[name] for name in ("before", "code", "sign", "behind") if match[name])
        if currency := _currency(unit, own):
            yield float(f"{re.sub(r'[^0-9]', '', match['whole'])}.{match['cents'] or 0}"), currency


def _currency(unit: str, own: str) -> str:
    """What a code or a sign stands for: a mere $ for the study's own dollar; empty for an unknown one, such as R$."""
    if not unit.endswith("$"):
        return _SIGNS.get(unit, unit)
    order = (own, *_DOLLARS) if own in _DOLLARS else _DOLLARS
    return next((one for one in order if one.startswith(unit[:-1])), "")
