"""Reasons to distrust a comparison that lie in the planned orders, as they may by earlier rules of allocation."""

from collections.abc import Iterator, Mapping

from movingout.recordings.report.words import Phrase
from movingout.study.analysis.results import Flag
from movingout.study.design.allocation import assign, letters
from movingout.study.design.balance import MapBySeat, uneven_seats
from movingout.study.design.definition import Study


def design_flags(study: Study, *, blinded: bool) -> Iterator[Flag]:
    """Blocks in which seats go together with partners or maps, one flag each."""
    names = letters(study) if blinded else {}
    for one in uneven_seats(study, [assign(study, slot) for slot in range(study.units)]):
        if isinstance(one, MapBySeat):
            yield Flag("", one.block, _map_and_seat(one, names))
        else:
            counts = sorted(f"{names.get(partner, partner)} {blue} / {red}" for partner, blue, red in one.rounds)
            yield Flag("", one.block, Phrase("study.flag.partners_by_seat", {"counts": ", ".join(counts)}))


def _map_and_seat(one: MapBySeat, names: Mapping[str, str]) -> Phrase:
    key = "study.flag.partner_and_map_by_seat" if one.partner else "study.flag.map_by_seat"
    partner = names.get(one.partner, one.partner)
    return Phrase(key, {"map": one.map, "partner": partner, "blue": one.blue, "red": one.red})
