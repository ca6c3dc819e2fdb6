"""The start page: choosing a map and who plays, by mouse, by keyboard and on a phone."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, Route, expect

from tests.browser.pages import complaining_page, overflow, sent_body, violations
from tests.browser.support import PHONE, Server

SMALL_PHONE = {"width": 375, "height": 553}

OpenPage = Callable[..., Page]


def ready(page: Page) -> Page:
    expect(page.locator("#play")).to_be_enabled()
    return page


def tokens_of_room(page: Page) -> list[str]:
    """What the tab keeps for the room whose page it is on."""
    room = page.url.rsplit("/", 1)[1]
    tokens: list[str] = page.evaluate("room => JSON.parse(sessionStorage.getItem(`movingout.tokens.${room}`))", room)
    return tokens


def test_twelve_maps_stand_in_their_three_modes_with_a_picture_each(open_page: OpenPage) -> None:
    page = ready(open_page("/"))
    titles = page.locator(".map-group").evaluate_all(
        "groups => groups.map(group => [group.querySelector('h2').textContent, group.querySelectorAll('.map').length])"
    )
    assert titles == [["Coordination", 4], ["Awareness", 4], ["Action consistency", 4]]
    colours = page.locator(".map canvas").evaluate_all("""canvases => canvases.map(canvas => {
        const {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        return new Set(new Uint32Array(data.buffer)).size;
    })""")
    assert len(colours) == 12
    assert min(colours) > 20  # walls, goals, items and both robots are there


def test_in_forced_colours_hard_maps_have_more_dots(open_page: OpenPage) -> None:
    page = ready(open_page("/", forced_colors="active"))
    full, empty = (page.locator(dots).first for dots in (".dot-full", ".dot:not(.dot-full)"))
    ground = "dot => getComputedStyle(dot).backgroundColor"
    assert full.evaluate(ground) != empty.evaluate(ground)


def test_the_lobby_is_accessible_in_both_themes(open_page: OpenPage) -> None:
    page = ready(open_page("/"))
    page.locator("#more summary").click()
    page.get_by_text("Controls", exact=True).click()
    assert violations(page) == []


def test_a_trained_agent_has_a_card_of_one_line_at_the_desk_and_on_a_phone(open_page: OpenPage, pictures: Path) -> None:
    page = ready(open_page("/"))
    page.get_by_role("combobox", name="Red").select_option("agent:bass@all")
    card = page.locator("#seat-help-1")
    expect(card).to_contain_text(re.compile(r"Gets \d\d % of the work done with partners it never met"))
    page.locator("#more summary").click()
    research = page.locator("#research")
    expect(research).to_contain_text("Diffusion Policy with BASS, learned from")
    expect(research).to_contain_text(re.compile(r"TCR 0\.\d\d with scripted people it never met"))
    card.scroll_into_view_if_needed()
    page.screenshot(path=pictures / "lobby-card.png")
    page.set_viewport_size({"width": PHONE["width"], "height": PHONE["height"]})
    assert overflow(page) <= 0
    card.scroll_into_view_if_needed()
    page.screenshot(path=pictures / "lobby-card-phone.png")
    page.get_by_role("combobox", name="Red").select_option("agent:idle")
    expect(card).to_have_text("Does nothing: you play alone.")


def test_a_chosen_map_opens_a_room_and_its_seat_is_kept_in_the_tab(open_page: OpenPage, server: Server) -> None:
    page = ready(open_page("/"))
    page.get_by_role("radio", name="Left Right").check(force=True)
    page.get_by_role("combobox", name="Red").select_option("agent:idle")
    page.get_by_role("button", name="Play Left Right").click()
    page.wait_for_url("**/play/*")
    assert len(tokens_of_room(page)) == 1
    expect(page.get_by_role("heading", name="Left Right")).to_be_visible()


def test_the_whole_choice_is_made_by_keyboard(open_page: OpenPage) -> None:
    page = ready(open_page("/"))
    page.get_by_role("radio", name="Hand Off").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    expect(page.locator("#chosen h2")).to_have_text("Efficient Routes")
    page.keyboard.press("Enter")
    page.wait_for_url("**/play/*")


def test_two_people_at_one_screen_are_told_their_keys_and_get_both_seats(open_page: OpenPage) -> None:
    page = ready(open_page("/"))
    page.get_by_role("combobox", name="Red").select_option("here")
    expect(page.locator("#seats-note")).to_contain_text("W A S D")
    page.locator("#play").click()
    page.wait_for_url("**/play/*")
    assert len(set(tokens_of_room(page))) == 2


def test_all_twelve_maps_are_played_in_order(open_page: OpenPage) -> None:
    page = ready(open_page("/"))
    with page.expect_request("**/api/rooms") as sent:
        page.get_by_role("button", name="Play all 12 maps").click()
    body = sent_body(sent.value)
    assert len(body["maps"]) == 12
    assert (body["maps"][0], body["maps"][-1]) == ("HandOff", "SequentialRotations")
    page.wait_for_url("**/play/*")
    expect(page.locator("#round")).to_have_text("Round 1 of 12")


def test_without_a_seat_of_ones_own_the_link_and_its_code_are_shown(open_page: OpenPage) -> None:
    page = ready(open_page("/"))
    page.get_by_role("combobox", name="Blue").select_option("link")
    page.get_by_role("combobox", name="Red").select_option("remote")
    page.get_by_role("button", name="Open Distance Priority").click()
    heading = page.get_by_role("heading", name="The room is open")
    expect(heading).to_be_focused()
    room = page.locator(".share-address").inner_text().rsplit("/", 1)[1]
    expect(page.get_by_role("link", name="Watch the game")).to_have_attribute("href", f"/watch/{room}")
    page.wait_for_function("() => document.querySelector('.share-link img').naturalWidth > 0")
    assert violations(page) == []
    page.get_by_role("button", name="Back to the maps").click()
    expect(page.locator("#play")).to_be_visible()


def test_a_person_who_plays_with_a_program_sees_where_it_connects(open_page: OpenPage, server: Server) -> None:
    page = ready(open_page("/"))
    page.get_by_role("combobox", name="Red").select_option("remote")
    page.locator("#play").click()
    page.wait_for_url("**/play/*")
    expect(page.get_by_role("heading", name="Waiting for a program")).to_be_visible()
    expect(page.locator("#ready")).to_contain_text(f"{server.url.replace('http', 'ws')}/ws")
    expect(page.locator("#ready")).to_contain_text(page.url.rsplit("/", 1)[1])


def test_two_agents_are_watched(open_page: OpenPage) -> None:
    page = ready(open_page("/"))
    page.get_by_role("combobox", name="Blue").select_option("agent:idle")
    page.get_by_role("combobox", name="Red").select_option("agent:idle")
    page.get_by_role("button", name="Watch Distance Priority").click()
    page.wait_for_url("**/watch/*")


def test_practice_opens_the_practice_room_without_a_limit(open_page: OpenPage) -> None:
    page = ready(open_page("/"))
    with page.expect_request("**/api/rooms") as sent:
        page.get_by_role("button", name="Practise alone").click()
    body = sent_body(sent.value)
    assert (body["maps"], body["practice"]) == (["Simple"], True)
    page.wait_for_url("**/play/*")


def test_changed_items_need_a_number_and_the_field_gets_the_focus(open_page: OpenPage) -> None:
    page = ready(open_page("/"))
    page.locator("#more summary").click()
    page.get_by_label("Shuffled items").check()
    page.get_by_label("Number", exact=True).fill("seven")
    page.locator("#play").click()
    expect(page.get_by_role("alert").filter(has_text="one to nine digits")).to_be_visible()
    expect(page.get_by_label("Number", exact=True)).to_be_focused()
    page.get_by_label("Number", exact=True).fill("7")
    with page.expect_request("**/api/rooms") as sent:
        page.locator("#play").click()
    assert sent_body(sent.value)["challenge2_seed"] == 7
    page.wait_for_url("**/play/*")


def test_the_last_choice_is_there_on_the_next_visit(open_page: OpenPage) -> None:
    page = ready(open_page("/"))
    page.get_by_role("radio", name="Four Corners").check(force=True)
    page.get_by_role("combobox", name="Red").select_option("agent:idle")
    page.get_by_label("Time limit").select_option("900")
    page.locator("#play").click()
    page.wait_for_url("**/play/*")
    page.goto("/")
    ready(page)
    expect(page.locator("#chosen h2")).to_have_text("Four Corners")
    expect(page.get_by_role("combobox", name="Red")).to_have_value("agent:idle")
    expect(page.get_by_label("Time limit")).to_have_value("900")


@pytest.mark.parametrize(("code", "shown"), [("full", "server is full"), ("new_code", "Sorry, no.")])
def test_a_refusal_is_shown_by_its_code_else_as_the_servers_sentence(
    browser: Browser, server: Server, code: str, shown: str
) -> None:
    def refuse(route: Route) -> None:
        route.fulfill(
            status=503,
            content_type="application/json",
            body=json.dumps({"error": {"code": code, "message": "Sorry, no."}}),
        )

    with complaining_page(browser, server, "/") as page:
        ready(page)
        page.route("**/api/rooms", refuse)
        page.locator("#play").click()
        expect(page.get_by_role("alert").filter(has_text=shown)).to_be_visible()
        expect(page.locator("#play")).to_be_enabled()


@pytest.mark.slow
def test_a_slow_server_is_said_to_be_opening_the_game_and_a_second_press_opens_no_second_room(
    open_page: OpenPage,
) -> None:
    page = ready(open_page("/"))
    asked: list[Route] = []
    page.route("**/api/rooms", lambda route: asked.append(route))
    page.locator("#play").click()
    expect(page.locator("#problem")).to_have_text("Opening the game…")
    expect(page.locator("#play")).to_be_disabled()
    page.locator("#play").click(force=True)
    asked[0].continue_()
    page.wait_for_url("**/play/*")
    assert len(asked) == 1
    page.go_back()
    expect(page.locator("#play")).to_be_enabled()
    expect(page.locator("#problem")).to_be_empty()


def test_a_server_that_is_gone_is_said_and_its_return_noticed(browser: Browser, server: Server) -> None:
    with complaining_page(browser, server, "") as page:
        page.clock.install()
        page.route("**/api/maps", lambda route: route.abort())
        page.goto("/")
        expect(page.get_by_text("The server does not answer")).to_be_visible()
        expect(page.locator("#play")).to_be_disabled()
        page.unroute("**/api/maps")
        page.clock.run_for(3000)
        ready(page)


def test_the_theme_button_overrides_the_system_and_is_kept(open_page: OpenPage) -> None:
    page = ready(open_page("/", color_scheme="light"))
    background = "getComputedStyle(document.body).backgroundColor"
    light = page.evaluate(background)
    page.get_by_role("button", name="Theme").click()
    dark = page.evaluate(background)
    page.reload()
    ready(page)
    assert (light, dark, page.evaluate(background)) == ("rgb(245, 246, 248)", "rgb(18, 22, 28)", "rgb(18, 22, 28)")


def test_on_a_phone_nothing_is_cut_off_and_play_stays_at_hand(open_page: OpenPage) -> None:
    page = ready(open_page("/", viewport=PHONE))
    assert overflow(page) == 0
    expect(page.locator("#play")).not_to_be_visible()  # the two ways to start at once are in view
    page.mouse.wheel(0, 900)
    expect(page.locator("#play")).to_be_in_viewport(ratio=1)


@pytest.mark.parametrize("language", ["en", "de"])
@pytest.mark.parametrize("size", [(1440, 900), (375, 553), (390, 664), (360, 640), (720, 450)])
def test_learning_and_playing_at_once_come_first_and_need_no_scrolling(
    open_page: OpenPage, size: tuple[int, int], language: str
) -> None:
    page = ready(open_page(f"/?lang={language}", viewport={"width": size[0], "height": size[1]}))
    for button in ("#learn", "#play-now"):
        expect(page.locator(button)).to_be_in_viewport(ratio=1)
    assert overflow(page) <= 0
    focusable = page.locator("main :is(a, button, input, select)").evaluate_all("all => all.map(one => one.id)")
    assert focusable[:2] == ["learn", "play-now"]


def test_play_now_starts_an_easy_map_beside_a_partner_who_helps(open_page: OpenPage) -> None:
    page = ready(open_page("/"))
    with page.expect_request("**/api/rooms") as sent:
        page.get_by_role("button", name="Play now").click()
    body = sent_body(sent.value)
    assert body["maps"] == ["DistancePriority"]
    assert body["seats"] == [{"kind": "here"}, {"kind": "partner"}]
    page.wait_for_url("**/play/*")
    expect(page.locator("#seats")).to_contain_text("trained for any map")


def test_whoever_comes_first_finds_an_easy_map_chosen_and_every_map_says_how_hard_it_is(open_page: OpenPage) -> None:
    page = ready(open_page("/"))
    expect(page.locator("#chosen h2")).to_have_text("Distance Priority")
    levels = page.locator(".map-difficulty").evaluate_all(
        "all => all.map(one => [one.textContent, one.querySelectorAll('.dot-full').length])"
    )
    assert len(levels) == 12
    assert {tuple(level) for level in levels} == {("easy", 1), ("medium", 2), ("hard", 3)}


def test_no_id_and_no_abbreviation_meets_whoever_only_wants_to_play(open_page: OpenPage) -> None:
    page = ready(open_page("/"))
    seen = page.locator("body").inner_text() + "".join(page.locator("option").all_inner_texts())
    assert not re.search(r"\w@\w|DP/BASS|\bTCR\b|\bidle\b|control condition", seen)


def test_the_operators_pages_are_folded_away_and_say_what_they_ask_for(open_page: OpenPage) -> None:
    page = ready(open_page("/"))
    for name in ("Recordings", "Running games"):
        expect(page.get_by_role("link", name=name)).to_be_hidden()
    page.get_by_text("For the person who runs this server").click()
    expect(page.get_by_text("ask for the admin token")).to_be_visible()
    page.get_by_role("link", name="Running games").click()
    expect(page.get_by_role("link", name="Start page")).to_be_visible()


def test_a_link_that_only_this_machine_opens_says_so_and_what_helps(open_page: OpenPage) -> None:
    page = ready(open_page("/"))
    page.get_by_role("combobox", name="Red").select_option("link")
    page.locator("#play").click()
    page.wait_for_url("**/play/*")
    warning = page.locator("#ready .loopback")
    expect(warning).to_contain_text("Only this device can open this link.")
    expect(warning).to_contain_text("another address that the server printed")
    expect(warning).to_contain_text("movingout play --host 0.0.0.0 --tls")


def test_a_phone_sends_the_link_its_own_way(open_page: OpenPage) -> None:
    script = "navigator.share = async (what) => { window.shared = what; };"
    page = ready(open_page("/", script=script, viewport=SMALL_PHONE, has_touch=True, is_mobile=True))
    page.get_by_role("combobox", name="Blue").select_option("link")
    page.get_by_role("combobox", name="Red").select_option("agent:idle")
    page.get_by_role("combobox", name="Red").scroll_into_view_if_needed()
    page.locator("#play").tap()
    page.get_by_role("button", name="Send the link…").tap()
    assert page.evaluate("window.shared.url") == page.locator(".share-address").inner_text()
    assert overflow(page) <= 0


def test_playing_at_once_needs_no_mouse(open_page: OpenPage) -> None:
    page = ready(open_page("/"))
    page.locator("#language").focus()
    page.keyboard.press("Tab")
    expect(page.locator("#learn")).to_be_focused()
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    page.wait_for_url("**/play/*")
    expect(page.locator("#ready")).to_contain_text("You are blue")
