"""The sentences of reports, by language: a JSON file per language beside each report, found by key."""

import json
import re
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from movingout.maps.spec import ItemSpec, MapSpec

OWN = Path(__file__).with_name("languages")
PAGES = Path(__file__).parents[2] / "web" / "words"  # what the pages of the server say, a file per language
DEFAULT = "en"
LANGUAGES = tuple(sorted(file.stem for file in OWN.glob("*.json")))


class Phrase(NamedTuple):
    """A sentence before it is said in a language: its key, and what stands in its places."""

    key: str
    values: dict[str, Any] = {}  # noqa: RUF012  # never changed


class Words:
    """What a report says in one language.

    `folders` hold a `<language>.json` each; a language without files is said in English, and so is a missing text.
    """

    def __init__(self, language: str = DEFAULT, folders: Sequence[Path] = ()) -> None:
        base = language.partition("-")[0]
        self.language = base if base in LANGUAGES else DEFAULT
        places = (PAGES, OWN, *folders)
        self._texts: dict[str, str] = {}
        for spoken in dict.fromkeys((DEFAULT, self.language)):
            for place in places:
                self._texts |= _texts(place / f"{spoken}.json")

    def say(self, key: str, **values: Any) -> str:
        """The text of a key with its places filled; `count` chooses between `KEY.one` and `KEY.other`.

        Numbers, items and phrases among the values are said in the language as well.
        """
        if "count" in values:
            key += ".one" if values["count"] == 1 else ".other"
        return self._texts[key].format(**{name: self._value(value) for name, value in values.items()})

    def phrase(self, phrase: Phrase) -> str:
        return self.say(phrase.key, **phrase.values)

    def known(self, key: str, otherwise: str) -> str:
        """The text of a key, or `otherwise` where there is none, as of metrics that other packages add."""
        return self._texts.get(key, otherwise)

    def decimal(self, text: str) -> str:
        """A text that is a number or several, with the decimal sign of the language: 0.5 ± 0.1, or 0,5 ± 0,1."""
        sign = self._texts["number.decimal"]
        listed = text.replace(", ", "; ") if sign == "," else text
        return re.sub(r"(?<=\d)\.(?=\d)", sign, listed)

    def map_title(self, spec: MapSpec) -> str:
        """The title of a map, translated where the pages know the map; others keep their own."""
        return spec.title if self.language == DEFAULT else self.known(f"map.{spec.name}.title", spec.title)

    def item(self, item: ItemSpec) -> str:
        """Size and shape: "middle rectangle"."""
        return self.say("item", size=self.say(f"item.size.{item.size}"), shape=self.say(f"item.shape.{item.shape}"))

    def _value(self, value: Any) -> Any:
        if isinstance(value, Phrase):
            return self.phrase(value)
        if isinstance(value, ItemSpec):
            return self.item(value)
        if isinstance(value, int):
            return f"{value:,}".replace(",", self._texts["number.thousands"])
        if isinstance(value, float):
            return self.decimal(f"{value:.1f}")
        if isinstance(value, list):
            return ", ".join(str(self._value(one)) for one in value)
        return value


@cache
def _texts(file: Path) -> dict[str, str]:
    texts: dict[str, str] = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
    return texts
