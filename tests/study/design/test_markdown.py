"""The consent and the debriefing as participants' pages can show them: no pictures from elsewhere, no styles."""

import json

from movingout.study.design.markdown import html
from movingout.study.design.review import review
from movingout.study.design.study_file import parse_study
from tests.study.design.small_study import SMALL

SVG = "![Logo](data:image/svg+xml;base64,PHN2Zz4=)"
INSIDE = "![Dot](data:image/png;base64,iVBORw0KGgo=)"


def test_columns_are_aligned_without_a_style_which_the_pages_drop() -> None:
    table = html("| who | EUR |\n|---|----:|\n| all | 5 |\n\nSee [us][here].\n\n[here]: https://example.org\n")
    assert "style" not in table
    assert '<th align="right">EUR</th>' in table and '<td align="right">5</td>' in table and "<td>all</td>" in table
    assert '<a href="https://example.org">us</a>' in table


def test_pictures_that_participants_would_not_see_are_named_and_those_in_the_text_are_shown() -> None:
    linked = "[![Logo](https://uni.example/logo.png)](https://uni.example)"
    text = f"{INSIDE} {linked} {SVG} `{SVG}` `![no](picture)` ![Map][m]\n\n[m]: m.png"
    both = "{en: '![Logo](logo.png)', de: '![Logo](logo.png)'}"
    file = SMALL.replace("debrief: {text: They were programs.}", f"debrief: {{text: {both}}}")
    study = parse_study(file.replace("text: We record how you play.", f"text: {json.dumps(text)}"))
    named = [one.partition(", which")[0] for one in review(study).warnings if "picture" in one]
    assert named == [
        "the consent has the picture https://uni.example/logo.png",
        "the consent has the picture data:image/svg+xml",
        "the consent has the picture m.png",
        "the debriefing has the picture logo.png",
    ]
    assert html(INSIDE) == '<p><img src="data:image/png;base64,iVBORw0KGgo=" alt="Dot" /></p>\n'
