"""Which blocks a report may count together."""

import pytest

from movingout.study.design.definition import Study
from movingout.study.design.pooling import pooled_blocks
from movingout.study.design.review import review
from movingout.study.design.study_file import parse_study
from tests.study.design.small_study import SMALL

BLOCK = SMALL[SMALL.index("  - id: play") : SMALL.index("questionnaires:")]


def with_blocks(**blocks: str) -> Study:
    """The small study with these blocks: their partners, and their maps."""
    written = [f"  - {{id: {name}, partners: [{met.replace(' on ', '], maps: [')}]}}\n" for name, met in blocks.items()]
    return parse_study(SMALL.replace(BLOCK, "".join(written)))


@pytest.mark.parametrize(
    ("blocks", "pooled"),
    [
        ({"k": "one, two on HandOff", "m": "one, two on LeftRight"}, [["k", "m"]]),
        ({"k": "one on HandOff, LeftRight", "m": "two on LeftRight, HandOff"}, [["k", "m"]]),
        ({"k": "one on HandOff", "m": "one, two on LeftRight"}, [["k"], ["m"]]),
        ({"k": "one on HandOff", "m": "two on LeftRight", "n": "two on HandOff"}, [["k", "n"], ["m"]]),
        ({"k": "one on HandOff", "m": "two on HandOff", "n": "one, two on LeftRight"}, [["k", "m", "n"]]),
    ],
)
def test_blocks_are_pooled_where_all_partners_are_met_on_the_same_maps(
    blocks: dict[str, str], pooled: list[list[str]]
) -> None:
    study = with_blocks(**blocks)
    assert pooled_blocks(study) == pooled
    told = [one for one in review(study).warnings if "some partners are met on other maps than others" in one]
    assert [one.partition(":")[0] for one in told] == [f"blocks {' and '.join(blocks)}"] * (len(pooled) > 1)


def test_blocks_are_pooled_where_maps_have_the_same_shares_of_the_rounds() -> None:
    alike = with_blocks(k="one on HandOff", m="two on HandOff", n="one on LeftRight", o="two on LeftRight")
    assert pooled_blocks(alike) == [["k", "m", "n", "o"]]
    k, m, n, o = alike.blocks
    more = [k.model_copy(update={"rounds": 4}), m, n, o.model_copy(update={"rounds": 4})]
    assert pooled_blocks(alike.model_copy(update={"blocks": more})) == [["k", "m"], ["n", "o"]]
