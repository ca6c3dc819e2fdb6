"""The page after a round: for people, with ways to play on, at every size, and a picture to share."""

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from PIL import Image
from playwright.sync_api import Page, expect

from movingout.maps import load_map, map_to_json
from tests.browser.pages import overflow, sent_body, violations
from tests.browser.support import Server, start, wait_for
from tests.browser.test_languages import english_on

OpenPage = Callable[..., Page]


def over(server: Server, open_page: OpenPage, limit_ticks: int = 15, red: str = "idle", **options: Any) -> Page:
    """The result of a short round on Simple."""
    room = server.make_room("Simple", red=red, limit_ticks=limit_ticks)
    page = open_page(room["join_path"], room, **options)
    start(page)
    wait_for(page, "game.phase === 'series_over'", 60)
    expect(page.get_by_role("heading", level=1)).to_be_focused()
    return page


@pytest.mark.slow
def test_the_result_is_said_in_plain_words_and_the_measures_are_folded(server: Server, open_page: OpenPage) -> None:
    page = over(server, open_page)
    expect(page.get_by_role("heading", level=1)).to_have_text("You delivered 0 of 3")
    expect(page.locator(".delivery-who")).to_have_text(["not delivered"] * 3)
    seen = page.locator("body").inner_text()
    assert not any(short in seen for short in ("TCR", "NFD", "WT", "INT"))
    page.get_by_text("Details").click()
    expect(page.locator("[data-measure=tcr]")).to_be_visible()
    assert violations(page) == []


@pytest.mark.slow
@pytest.mark.parametrize("way", ["Next map", "Play again"])
def test_a_double_press_opens_one_further_room(server: Server, open_page: OpenPage, way: str) -> None:
    room = server.make_room("Simple", red="idle", limit_ticks=600)
    page = open_page(room["join_path"], room)
    start(page)
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Stop the game").click()
    page.get_by_role("button", name="Yes, stop").click()  # this room is over
    opened: list[str] = []
    page.on("request", lambda request: opened.append(request.url) if request.method == "POST" else None)
    page.get_by_role("button", name=way).dblclick()
    page.wait_for_url(lambda url: not url.endswith(room["join_path"]))
    page.get_by_role("button", name="I am ready").wait_for()
    assert opened == [f"{server.url}/api/rooms"]


@pytest.mark.slow
def test_the_best_so_far_is_remembered_in_this_browser(server: Server, open_page: OpenPage) -> None:
    page = over(server, open_page, limit_ticks=50)
    expect(page.locator(".result-best")).to_have_count(0)  # the first round has nothing to be compared with
    page.get_by_role("button", name="Play again").click()
    wait_for(page, "game.phase === 'playing'")
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Stop the game").click()
    expect(page.get_by_role("heading", name="Stop the game?", exact=True)).to_be_visible()  # nobody else plays
    page.get_by_role("button", name="Yes, stop").click()
    expect(page.get_by_text("You stopped the round.")).to_be_visible()
    expect(page.locator(".result-best")).to_have_count(0)  # a round that was stopped is no result
    page.get_by_role("button", name="Play again").click()  # in a new room: this one is over
    start(page)
    wait_for(page, "game.phase === 'series_over'", 60)
    expect(page.locator(".result-best")).to_contain_text("so far in this browser")


@pytest.mark.slow
def test_one_plays_on_with_the_same_partner_or_chooses_another(server: Server, open_page: OpenPage) -> None:
    page = over(server, open_page)
    with page.expect_request("**/api/rooms") as sent:
        page.get_by_role("button", name="Next map").click()
    body = sent_body(sent.value)
    assert body["seats"] == [{"kind": "here"}, {"kind": "agent", "agent": "idle"}]
    assert (len(body["maps"]), body["limit_ticks"]) == (1, 15)
    assert body["maps"] != ["Simple"]
    page.wait_for_url(lambda url: "/play/" in url)
    start(page)
    wait_for(page, "game.phase === 'series_over'", 60)
    page.get_by_role("link", name="Another partner").click()
    expect(page.get_by_role("combobox", name="Red")).to_be_focused()
    expect(page.locator("#chosen h2")).to_have_text("Hand Off")


@pytest.mark.slow
def test_shuffled_items_stay_shuffled_in_the_game_after_it(server: Server, open_page: OpenPage) -> None:
    room = server.make_room("DistancePriority", red="idle", limit_ticks=600, challenge2_seed=77)
    page = open_page(room["join_path"], room)
    start(page)
    shapes = "window.__movingout.entities().items.map(({shape, size}) => `${size} ${shape}`)"
    items = page.evaluate(shapes)
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Stop the game").click()
    page.get_by_role("button", name="Yes, stop").click()  # this room is over
    page.get_by_role("button", name="Play again").click()
    page.wait_for_url(lambda url: not url.endswith(room["join_path"]))
    start(page)
    assert page.evaluate(shapes) == items
    page.keyboard.press("Escape")
    page.get_by_role("button", name="Stop the game").click()
    page.get_by_role("button", name="Yes, stop").click()
    page.get_by_role("link", name="Another partner").click()
    expect(page.get_by_label("Shuffled items")).to_be_checked()
    expect(page.get_by_label("Number", exact=True)).to_have_value("77")
    expect(page.locator("#chosen h2")).to_have_text("Distance Priority")
    with page.expect_request("**/api/rooms") as sent:
        page.locator("#play").click()
    assert sent_body(sent.value)["challenge2_seed"] == 77


@pytest.mark.slow
def test_a_drawn_map_is_there_when_one_chooses_another_partner(server: Server, open_page: OpenPage) -> None:
    drawn = map_to_json(load_map("Simple")) | {"name": "Attic", "title": "The attic", "mode": "practice"}
    seats = [{"kind": "here"}, {"kind": "agent", "agent": "idle"}]
    room = server.post("/api/rooms", {"maps": [], "map": drawn, "seats": seats, "limit_ticks": 15})
    page = open_page(room["join_path"], room)
    start(page)
    another = page.get_by_role("link", name="Another partner")
    expect(another).to_be_visible(timeout=60_000)
    expect(page.get_by_role("link", name="Edit the map")).to_have_count(0)  # it was not drawn in this browser
    another.click()
    expect(page.locator("#chosen h2")).to_have_text("The attic")
    group = page.locator(".map-group", has=page.get_by_role("heading", name="Just played"))
    expect(group.get_by_role("radio", name="The attic")).to_be_checked()
    expect(page.get_by_role("combobox", name="Red")).to_be_focused()
    with page.expect_request("**/api/rooms") as request:
        page.get_by_role("button", name="Play The attic").click()
    assert sent_body(request.value)["map"]["title"] == "The attic"
    page.wait_for_url(lambda url: "/play/" in url)
    expect(page.locator("#title")).to_have_text("The attic")


@pytest.mark.slow
@pytest.mark.parametrize(("width", "height"), [(375, 553), (740, 360)])
def test_who_has_played_the_own_drawing_may_go_on_drawing(
    server: Server, open_page: OpenPage, pictures: Path, width: int, height: int
) -> None:
    drawn = map_to_json(load_map("Simple")) | {"name": "Attic", "title": "The attic", "mode": "practice"}
    seats = [{"kind": "here"}, {"kind": "agent", "agent": "idle"}]
    room = server.post("/api/rooms", {"maps": [], "map": drawn, "seats": seats, "limit_ticks": 15})
    phone = {"viewport": {"width": width, "height": height}, "is_mobile": True, "has_touch": True}
    page = open_page(room["join_path"], room, **phone)
    page.evaluate("drawn => localStorage.setItem('movingout.editor', JSON.stringify(drawn))", drawn)
    page.evaluate("room => sessionStorage.setItem('movingout.drawn', room)", room["room"])
    start(page)
    edit = page.get_by_role("link", name="Edit the map")
    expect(edit).to_be_visible(timeout=60_000)
    assert overflow(page) == 0
    page.screenshot(path=pictures / f"result-drawn-{width}.png", full_page=True)
    edit.click()
    expect(page.get_by_label("Title")).to_have_value("The attic")


@pytest.mark.slow
@pytest.mark.parametrize(("name", "kind"), [("Save a picture", "PNG"), ("Save an animation", "GIF")])
def test_the_round_is_saved_as_a_picture_or_an_animation(
    server: Server, open_page: OpenPage, name: str, kind: str
) -> None:
    page = over(server, open_page)
    with page.expect_download() as download:
        page.get_by_role("button", name=name).click()
    content = Path(download.value.path()).read_bytes()
    assert Image.open(io.BytesIO(content)).format == kind
    assert download.value.suggested_filename == f"moving-out.{kind.lower()}"
    expect(page.get_by_text("Saved.")).to_be_visible()
    expect(page.get_by_role("button", name=name)).to_be_focused()


@pytest.mark.slow
def test_a_phone_sends_it_its_own_way_and_everything_to_go_on_is_in_view(server: Server, open_page: OpenPage) -> None:
    script = "navigator.canShare = () => true; navigator.share = async ({files}) => { window.sent = files[0].type; };"
    page = over(
        server, open_page, script=script, viewport={"width": 375, "height": 553}, has_touch=True, is_mobile=True
    )
    for way in ("Next map", "Play again"):
        expect(page.get_by_role("button", name=way)).to_be_in_viewport(ratio=1)
    assert overflow(page) == 0
    page.get_by_role("button", name="Send a picture…").tap()
    page.wait_for_function("() => window.sent === 'image/png'")


@pytest.mark.slow
@pytest.mark.parametrize("size", [(390, 664), (360, 640), (720, 450), (1024, 768), (1440, 900)])
def test_the_result_uses_the_width_and_nothing_is_cut_off(
    server: Server, open_page: OpenPage, size: tuple[int, int]
) -> None:
    page = over(server, open_page, viewport={"width": size[0], "height": size[1]})
    assert overflow(page) == 0
    expect(page.get_by_role("button", name="Next map")).to_be_in_viewport(ratio=1)
    width = page.locator(".result").bounding_box()
    assert width is not None and width["width"] >= min(1100, 0.9 * size[0]) - 8
    expect(page.locator("#seats")).to_be_hidden()  # the game's own columns make room


@pytest.mark.slow
def test_the_result_in_german_is_german_and_accessible(server: Server, open_page: OpenPage) -> None:
    room = server.make_room("Simple", red="idle", limit_ticks=15)
    page = open_page(room["join_path"] + "?lang=de", room)
    page.get_by_role("button", name="Ich bin bereit").click()
    expect(page.get_by_role("heading", level=1, name="Sie haben 0 von 3 abgeliefert")).to_be_focused()
    items = page.get_by_role("listitem").filter(has_text="nicht abgeliefert")
    expect(items.first).to_have_text("Stern: nicht abgeliefert")  # as it is heard; "einen Stern" is carried
    page.get_by_text("Einzelheiten").click()
    assert english_on(page) == []
    assert violations(page) == []
    page.get_by_role("button", name="10 Fragen zu Ihrem Partner beantworten").click()
    expect(page.get_by_role("heading", level=1, name="Über Ihren Partner")).to_be_visible()
    assert english_on(page) == []


@pytest.mark.slow
def test_on_a_phone_who_delivered_what_stays_in_its_box_in_german(server: Server, open_page: OpenPage) -> None:
    room = server.make_room("Simple", red="scripted", limit_ticks=100)
    phone = {"viewport": {"width": 375, "height": 553}, "has_touch": True, "is_mobile": True, "locale": "de-DE"}
    page = open_page(room["join_path"], room, **phone)
    page.get_by_role("button", name="Ich bin bereit").tap()
    expect(page.locator(".delivery-done")).not_to_have_count(0, timeout=60_000)
    expect(page.locator(".delivery-done").first).to_contain_text("Computerpartner")
    widths = page.locator(".delivery").evaluate_all("boxes => boxes.map(box => [box.scrollWidth, box.clientWidth])")
    assert all(needed <= there for needed, there in widths)
    assert overflow(page) == 0


@pytest.mark.slow
def test_one_plays_on_by_keyboard(server: Server, open_page: OpenPage) -> None:
    page = over(server, open_page)
    page.keyboard.press("Tab")
    expect(page.get_by_role("button", name="Next map")).to_be_focused()
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")  # Play again
    wait_for(page, "game.phase === 'playing'")


def test_the_hint_of_a_map_is_on_the_game_page(server: Server, open_page: OpenPage) -> None:
    room = server.make_room("HandOff", red="idle")
    page = open_page(room["join_path"], room)
    expect(page.locator("#ready")).to_contain_text("One narrow pathway: whoever is nearer passes the items down")


def test_an_address_in_the_hint_of_a_map_hides_no_part_of_the_button(server: Server, open_page: OpenPage) -> None:
    drawn = map_to_json(load_map("Simple")) | {"name": "drawn", "description": f"https://example.org/{'rooms' * 30}"}
    room = server.post("/api/rooms", {"map": drawn, "seats": [{"kind": "here"}, {"kind": "agent", "agent": "idle"}]})
    page = open_page(room["join_path"], room)
    card = page.locator("#ready")
    expect(card.get_by_role("button", name="I am ready")).to_be_visible()
    assert card.evaluate("card => card.scrollWidth <= card.clientWidth")
