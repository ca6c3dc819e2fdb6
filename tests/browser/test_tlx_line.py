"""The line of the NASA TLX on which people mark how demanding something was."""

import itertools

from playwright.sync_api import expect

from movingout.study.design.instruments import NASA_TLX
from tests.browser import study_fake as fake
from tests.browser.conftest import OpenPage
from tests.browser.pages import heading
from tests.browser.study_fake import FakeStudy
from tests.browser.support import PHONE


def test_a_finger_on_the_handle_of_the_nasa_tlx_line_chooses_where_it_stands(open_page: OpenPage) -> None:
    study = FakeStudy.at(fake.questions(NASA_TLX))
    page = open_page("/healthz", viewport=PHONE, has_touch=True, is_mobile=True)
    study.open(page)
    heading(page, "How demanding it was")
    page.locator(".tlx").first.tap()
    expect(page.locator(".tlx").first).to_have_attribute("data-chosen", "true")
    expect(page.locator(".questionnaire-status")).to_have_attribute("data-waiting", "0")
    assert study.answers() == {"mental": (10, "")}


def test_the_marks_of_the_nasa_tlx_line_lie_evenly_at_every_width(open_page: OpenPage) -> None:
    study = FakeStudy.at(fake.questions(NASA_TLX))
    page = open_page("/healthz")
    study.open(page)
    heading(page, "How demanding it was")
    for width in (360, 375, 701, 1280):
        page.set_viewport_size({"width": width, "height": 800})
        marks = page.locator(".tlx-ticks").first.locator("span")
        places: list[float] = marks.evaluate_all("marks => marks.map(one => one.getBoundingClientRect().x)")
        gaps = {round(after - before, 3) for before, after in itertools.pairwise(places)}
        assert len(places) == 21 and len(gaps) == 1 and gaps.pop() % 1 == 0, width
