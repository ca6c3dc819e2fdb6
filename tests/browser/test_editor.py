"""The map editor: drawing by mouse, touch and keyboard, checks, a trial by computer players, files, and playing it."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Locator, Page, expect

from movingout.maps import load_map, map_from_json, map_to_json
from tests.browser.pages import overflow, violations
from tests.browser.support import start, wait_for

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Page]
TOOL_LINES = "[...new Set([...document.querySelectorAll('.editor-tools .button')].map((one) => one.offsetTop))]"
SMALL_PHONE = {"width": 375, "height": 553}
DROP = """text => {
    const data = new DataTransfer();
    data.items.add(new File([text], "dropped.json", { type: "application/json" }));
    document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
}"""
SOUND = "This map can be played."


def drawn(page: Page) -> dict[str, Any]:
    document: dict[str, Any] = page.evaluate("window.__editor.drawing.map")
    return document


def ready(page: Page) -> Page:
    page.wait_for_function("() => window.__editor?.checks().known", timeout=20_000)
    expect(page.locator("#verdict")).to_have_text(SOUND)
    return page


def place(page: Page, x: float, y: float) -> tuple[float, float]:
    """Where a place of the arena is on the page."""
    box = page.locator("#arena").bounding_box()
    assert box is not None
    return box["x"] + (x + 1.2) / 2.4 * box["width"], box["y"] + (1.2 - y) / 2.4 * box["height"]


def drag(page: Page, start_at: tuple[float, float], end_at: tuple[float, float]) -> None:
    page.locator("#arena").scroll_into_view_if_needed()
    page.mouse.move(*place(page, *start_at))
    page.mouse.down()
    page.mouse.move(*place(page, *end_at), steps=4)
    page.mouse.up()


def tool(page: Page, name: str) -> Locator:
    return page.get_by_role("toolbar").get_by_role("button", name=name, exact=True)


def test_a_map_is_drawn_checked_solved_and_played(open_page: OpenPage, pictures: Path) -> None:
    page = ready(open_page("/editor", viewport={"width": 1280, "height": 800}))
    tool(page, "Wall").click()
    drag(page, (-0.5, 0.3), (0.5, 0.4))
    assert [drawn(page)["walls"][0][key] for key in ("x0", "y0", "x1", "y1")] == [-0.5, 0.3, 0.5, 0.4]
    tool(page, "Item").click()
    page.locator("#new-shape").select_option("hexagon")
    page.locator("#new-size").select_option("large")
    drag(page, (0.4, 0.35), (0.4, 0.35))  # onto the wall
    expect(page.locator("#faults")).to_have_text("Item 2 stands in Wall 1. Walls are a little thicker than drawn.")
    expect(page.locator("#play")).to_be_disabled()
    page.screenshot(path=pictures / "editor-fault.png")
    assert violations(page) == []
    page.locator("#faults button").click()
    expect(page.locator("#parts")).to_have_value("items[1]")
    drag(page, (0.4, 0.35), (0.6, -0.2))
    ready(page)
    page.get_by_label("Title").fill("Two rooms")
    assert drawn(page)["name"] == "TwoRooms"
    ready(page)
    page.get_by_role("button", name="Solve it").press("Enter")
    expect(page.locator("#message")).to_contain_text("All 2 items were delivered after", timeout=40_000)
    expect(page.locator("#trial")).to_be_visible()
    expect(page.locator("#solve")).to_be_focused()
    page.get_by_label("Time").fill("30")
    page.screenshot(path=pictures / "editor-solved.png")
    assert violations(page) == []
    page.get_by_role("button", name="Back to drawing").click()
    page.get_by_role("button", name="Play it").click()
    page.wait_for_url("**/play/*")
    start(page)
    assert page.evaluate("sessionStorage.getItem('movingout.drawn')") == page.url.rpartition("/")[2]  # the way back
    assert page.evaluate("window.__movingout.entities().items.length") == 2
    wait_for(page, "game.tick > 1")


def test_undo_redo_delete_and_duplicate_and_a_reload_loses_nothing(open_page: OpenPage) -> None:
    page = ready(open_page("/editor"))
    tool(page, "Green area").click()
    drag(page, (-1.0, -0.2), (-0.6, 0.2))
    first = drawn(page)
    page.get_by_role("button", name="Duplicate").click()
    assert len(drawn(page)["goals"]) == 3
    page.get_by_role("button", name="Delete").click()
    assert drawn(page) == first
    for _ in range(3):
        page.get_by_role("button", name="Undo").click()
    assert len(drawn(page)["goals"]) == 1
    page.get_by_role("button", name="Redo").click()
    assert drawn(page) == first
    page.reload()
    ready(page)
    assert drawn(page) == first


def test_the_whole_map_is_drawn_by_keyboard(open_page: OpenPage) -> None:
    page = ready(open_page("/editor"))
    page.locator("#arena").focus()
    for key in ("w", "Enter", "ArrowDown", "ArrowDown", "Shift+ArrowLeft", "r"):
        page.keyboard.press(key)
    (wall,) = drawn(page)["walls"]
    assert (min(wall["y0"], wall["y1"]), min(wall["x0"], wall["x1"])) == (-0.4, -0.06)
    page.keyboard.press("Control+z")
    page.keyboard.press("Control+y")
    assert drawn(page)["walls"] == [wall]
    page.keyboard.press("Delete")
    assert drawn(page)["walls"] == []
    page.locator("#parts").focus()
    page.locator("#parts").select_option("items[0]")
    page.get_by_label("Angle in degrees").fill("90")
    page.get_by_label("Size", exact=True).last.select_option("large")
    item = drawn(page)["items"][0]
    assert (item["angle"], item["size"], item["scale"]) == (1.571, "large", 0.17)
    page.get_by_label("Angle in degrees").press("Control+z")  # a text's own undo, not the drawing's
    ready(page)


def test_what_is_written_in_arabic_begins_at_the_right(open_page: OpenPage) -> None:
    page = open_page("/editor")
    for field in ("Title", "Description"):
        assert page.get_by_label(field).evaluate("(one) => getComputedStyle(one).unicodeBidi") == "plaintext", field


def test_a_screen_reader_hears_what_the_keys_do(open_page: OpenPage) -> None:
    page = ready(open_page("/editor"))
    page.locator("#arena").focus()
    said = page.locator("#announce")
    for key, sentence in {
        "w": "Wall",
        "Enter": "Wall 1 added.",
        "ArrowDown": "Left -0.30; Bottom -0.10",
        "r": "Width 0.10; Height 0.60",
        ".": "Green area 1. Left -0.40; Bottom 0.70",
        "Control+z": "Undone.",
        "Control+y": "Redone.",
        ",": "Wall 1. Left -0.05; Bottom -0.35",
        "Delete": "Wall 1 deleted.",
    }.items():
        page.keyboard.press(key)
        expect(said).to_have_text(sentence)


def test_shortcuts_work_with_caps_lock_and_on_a_russian_keyboard(open_page: OpenPage) -> None:
    page = ready(open_page("/editor"))
    press = """([key, code]) => document.querySelector("#arena").dispatchEvent(
        new KeyboardEvent("keydown", { key, code, bubbles: true, ctrlKey: key === "я" }))"""
    for key, code in (("W", "KeyW"), ("Enter", "Enter"), ("ц", "KeyW"), ("Enter", "Enter")):
        page.evaluate(press, [key, code])
    assert len(drawn(page)["walls"]) == 2
    page.evaluate(press, ["я", "KeyZ"])
    assert len(drawn(page)["walls"]) == 1


def test_a_file_is_downloaded_and_opened_and_a_broken_one_loses_nothing(open_page: OpenPage, tmp_path: Path) -> None:
    page = ready(open_page("/editor"))
    page.locator("#start").select_option("HandOff")
    assert drawn(page)["title"] == "Hand Off, changed"
    ready(page)
    with page.expect_download() as download:
        page.get_by_role("button", name="Download").click()
    assert download.value.suggested_filename == "HandOffChanged.json"
    saved = json.loads(Path(download.value.path()).read_text(encoding="utf-8"))
    assert map_from_json(saved).walls == load_map("HandOff").walls
    before = drawn(page)
    broken = {
        "no.json": ("{", "it is not JSON"),
        "odd.json": (json.dumps(map_to_json(load_map("Simple")) | {"goals": 3}), "goals: a list is needed here"),
        "large.json": (" " * 70_000, "too large"),
    }
    for name, (content, sentence) in broken.items():
        (tmp_path / name).write_text(content, encoding="utf-8")
        page.locator("#file").set_input_files(tmp_path / name)
        expect(page.locator("#message")).to_contain_text(sentence)
        assert drawn(page) == before
    good = map_to_json(load_map("LeftRight")) | {"name": "Mine", "title": "<b>Mine</b>"}
    (tmp_path / "good.json").write_text(json.dumps(good), encoding="utf-8")
    page.locator("#file").set_input_files(tmp_path / "good.json")
    expect(page.get_by_label("Title")).to_have_value("<b>Mine</b>")
    assert drawn(page) == good
    page.get_by_role("button", name="Undo").click()
    assert drawn(page) == before
    page.evaluate(DROP, json.dumps(good))
    expect(page.get_by_label("Title")).to_have_value("<b>Mine</b>")


def test_what_is_missing_and_a_shipped_name_are_said(open_page: OpenPage) -> None:
    page = ready(open_page("/editor"))
    page.locator("#parts").select_option("items[0]")
    page.get_by_role("button", name="Delete").click()
    expect(page.locator("#faults")).to_have_text("Add an item.")
    page.get_by_role("button", name="Undo").click()
    page.get_by_label("Title").fill("Hand Off")
    expect(page.locator("#faults")).to_have_text("HandOff is the name of a map of this server. Choose another title.")


def test_hints_are_said_and_keep_nothing_from_being_played(open_page: OpenPage) -> None:
    page = ready(open_page("/editor"))
    drag(page, (0.0, 0.0), (0.0, 0.95))  # the item, into the goal
    expect(page.locator("#verdict")).to_have_text("This map can be played. Is this intended?")
    expect(page.locator("#faults")).to_have_text(
        "Item 1 lies in a green area from the start and counts as delivered. Move it out."
    )
    expect(page.locator("#play")).to_be_enabled()
    page.evaluate("document.querySelector('#arena').blur()")
    page.locator("#faults button").click()
    expect(page.locator("#arena")).to_be_focused()
    for _ in range(9):
        page.keyboard.press("ArrowDown")
    ready(page)


def test_another_title_takes_away_the_number_of_a_map_of_the_paper(open_page: OpenPage, tmp_path: Path) -> None:
    page = ready(open_page("/editor"))
    (tmp_path / "four.json").write_text(json.dumps(map_to_json(load_map("LeftRight"))), encoding="utf-8")
    page.locator("#file").set_input_files(tmp_path / "four.json")
    expect(page.locator("#faults")).to_contain_text("LeftRight is the name of a map of this server.")
    page.get_by_label("Title").fill("Mine")
    ready(page)
    assert (drawn(page)["name"], drawn(page)["number"]) == ("Mine", 0)


def test_the_arena_stays_where_it_is_when_items_are_added_and_the_most_are_told(open_page: OpenPage) -> None:
    page = ready(open_page("/editor", viewport={"width": 1280, "height": 800}))
    before = page.locator("#arena").bounding_box()
    for index in range(6):
        tool(page, "Item").click()
        expect(page.locator("#new-shape")).to_be_visible()
        assert page.locator("#arena").bounding_box() == before
        page.mouse.click(*place(page, -0.9 + 0.3 * index, 0.4))
    assert len(drawn(page)["items"]) == 7
    tool(page, "Item").click()
    expect(page.locator("#message")).to_have_text("A map has at most 7 items.")
    expect(tool(page, "Select")).to_have_attribute("aria-pressed", "true")
    page.locator("#snap").click()
    page.keyboard.press("Control+z")
    assert len(drawn(page)["items"]) == 6


def test_on_a_phone_a_map_is_changed_by_touch(open_page: OpenPage, pictures: Path) -> None:
    page = ready(open_page("/editor", viewport=SMALL_PHONE, has_touch=True, is_mobile=True))
    assert overflow(page) <= 0
    tool(page, "Wall").tap()
    page.touchscreen.tap(*place(page, 0.5, 0.2))
    assert len(drawn(page)["walls"]) == 1
    ready(page)
    page.screenshot(path=pictures / "editor-phone.png")
    box = page.locator("#arena").bounding_box()
    assert box is not None and box["y"] + box["height"] <= SMALL_PHONE["height"], "the whole arena is on the screen"
    page.screenshot(path=pictures / "editor-phone-whole.png", full_page=True)
    assert violations(page) == []
    page.goto("/editor?lang=de")
    page.wait_for_function("() => window.__editor?.checks().known")
    assert len(drawn(page)["walls"]) == 1
    assert overflow(page) <= 0
    page.screenshot(path=pictures / "editor-phone-german.png")


def test_a_copy_of_a_shipped_map_has_its_description_in_the_readers_language(open_page: OpenPage) -> None:
    page = open_page("/editor?lang=de")
    expect(page.locator("#verdict")).to_have_text("Diese Karte ist spielbar.", timeout=20_000)
    page.locator("#start").select_option("HandOff")
    expect(page.locator("#about")).to_have_value(re.compile("^Ein enger Gang"))


def test_on_a_phone_what_follows_a_press_is_in_sight(open_page: OpenPage, tmp_path: Path) -> None:
    page = open_page("/editor?lang=de", viewport=SMALL_PHONE, has_touch=True, is_mobile=True)
    expect(page.locator("#verdict")).to_have_text("Diese Karte ist spielbar.", timeout=20_000)
    page.locator("#start").scroll_into_view_if_needed()
    page.locator("#start").select_option("HandOff")
    expect(page.get_by_label("Titel")).to_have_value("Übergabe, geändert")
    expect(page.locator("#arena")).to_be_in_viewport(ratio=0.99)
    (tmp_path / "odd.json").write_text(json.dumps(map_to_json(load_map("Simple")) | {"goals": 3}), encoding="utf-8")
    page.locator("#open").scroll_into_view_if_needed()
    page.locator("#file").set_input_files(tmp_path / "odd.json")
    expect(page.locator("#message")).to_contain_text("goals: Hier muss eine Liste stehen.")
    expect(page.locator("#message")).to_be_in_viewport(ratio=0.99)
    page.locator("#solve").tap()
    expect(page.locator("#trial")).to_be_visible(timeout=40_000)
    expect(page.locator("#arena")).to_be_in_viewport(ratio=0.99)


@pytest.mark.parametrize(("width", "height"), [(740, 360), (932, 430)])
def test_on_a_phone_that_lies_on_its_side_the_whole_arena_is_seen_at_once(
    open_page: OpenPage, width: int, height: int
) -> None:
    lying = {"width": width, "height": height}
    page = ready(open_page("/editor?lang=en", viewport=lying, has_touch=True, is_mobile=True))
    box = page.locator("#arena").bounding_box()
    assert box is not None
    assert box["y"] + box["height"] <= height, "without scrolling"
    assert box["height"] > 0.8 * height
    assert width - box["width"] > 200, "beside it a finger can scroll"


@pytest.mark.parametrize("width", [320, 360, 768, 1280])
def test_back_and_forward_stand_side_by_side(open_page: OpenPage, width: int) -> None:
    page = open_page("/editor?lang=de", viewport={"width": width, "height": 720})
    expect(page.locator("#undo")).to_have_text("Rückgängig")
    undo, redo = page.locator("#undo").bounding_box(), page.locator("#redo").bounding_box()
    assert undo is not None and redo is not None
    assert undo["y"] == redo["y"]


def test_all_tools_stand_in_one_line_on_the_smallest_phone(open_page: OpenPage) -> None:
    page = ready(open_page("/editor", viewport={"width": 360, "height": 640}, has_touch=True, is_mobile=True))
    assert len(page.evaluate(TOOL_LINES)) == 1


def test_all_tools_stand_in_one_line_in_german(open_page: OpenPage) -> None:
    page = open_page("/editor?lang=de", viewport={"width": 1240, "height": 760})
    expect(page.locator("#verdict")).to_have_text("Diese Karte ist spielbar.", timeout=20_000)
    assert len(page.evaluate(TOOL_LINES)) == 1


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_is_german_where_the_reader_is(open_page: OpenPage, pictures: Path, scheme: str) -> None:
    page = open_page("/editor?lang=de", viewport={"width": 1280, "height": 800}, color_scheme=scheme)
    expect(page.locator("#verdict")).to_have_text("Diese Karte ist spielbar.", timeout=20_000)
    page.locator("#parts").select_option("robots.red")
    page.get_by_label("x", exact=True).fill("-0.55")
    expect(page.locator("#faults")).to_contain_text("Roboter Rot überlappt Roboter Blau.")
    page.screenshot(path=pictures / f"editor-german-{scheme}.png")
    assert overflow(page) <= 0
    assert violations(page) == []


def test_the_lobby_leads_to_the_editor_and_back(open_page: OpenPage) -> None:
    page = open_page("/")
    page.get_by_role("link", name="Draw a map").click()
    ready(page)
    page.get_by_role("link", name="All maps").click()
    expect(page.locator("#play")).to_be_enabled()


def test_two_tabs_go_on_with_what_was_drawn_in_the_other(open_page: OpenPage, pictures: Path) -> None:
    first = open_page("/editor", viewport=SMALL_PHONE, locale="de-DE")
    second = first.context.new_page()
    second.goto("/editor")
    for page in (first, second):
        page.wait_for_function("() => window.__editor?.checks().known")
    first.locator("#title").focus()
    second.locator("#title").fill("Zwei")
    second.evaluate("window.__editor.drawing.change({...window.__editor.drawing.map, goals: []})")
    expect(first.locator("#title")).to_have_value("Zwei")
    expect(first.locator("#message")).to_contain_text("in einem anderen Tab")
    first.locator("#message").scroll_into_view_if_needed()
    first.screenshot(path=pictures / "editor-another-tab-de.png")
    first.locator("#title").press_sequentially("!")
    expect(second.locator("#title")).to_have_value("Zwei!")
    assert drawn(first) == drawn(second) and drawn(first)["goals"] == []
    first.locator("#undo").click()
    first.locator("#undo").click()
    assert drawn(first)["title"] != "Zwei" and drawn(first)["goals"] != []


def test_two_tabs_with_two_maps_keep_to_their_own_also_after_a_reload(open_page: OpenPage) -> None:
    first = open_page("/editor")
    second = first.context.new_page()
    second.goto("/editor")
    for page in (first, second):
        page.wait_for_function("() => window.__editor?.checks().known")
    first.locator("#title").fill("One")
    expect(second.locator("#title")).to_have_value("One")
    second.locator("#start").select_option("-")
    second.locator("#title").fill("Two")
    first.locator("#title").fill("One!")
    second.locator("#title").fill("Two!")
    first.wait_for_timeout(200)
    assert (drawn(first)["title"], drawn(second)["title"]) == ("One!", "Two!")
    for page, title in ((first, "One!"), (second, "Two!")):
        page.reload()
        expect(page.locator("#title")).to_have_value(title)
