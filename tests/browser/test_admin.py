"""What the experimenter sees: running games, live, and the recordings."""

from collections.abc import Callable
from dataclasses import replace

import pytest
from playwright.sync_api import Browser, Page, Route, expect

from movingout.maps import load_map
from movingout.maps.json_format import map_to_json
from movingout.recordings import finalise
from tests.browser.pages import admin_token, complaining_page, overflow, violations
from tests.browser.support import PHONE, Server, start
from tests.recordings.support import record

pytestmark = pytest.mark.slow

OpenPage = Callable[..., Page]


def unlocked(server: Server) -> str:
    """A script that has given the token before."""
    return f"sessionStorage.setItem('movingout.admin', '{admin_token(server)}')"


def test_the_token_is_asked_for_once_and_a_wrong_one_is_refused_with_a_sentence(
    browser: Browser, server: Server
) -> None:
    with complaining_page(browser, server, "/admin") as page:
        page.get_by_label("Admin token").fill("guess")
        page.get_by_role("button", name="Open").click()
        expect(page.get_by_role("alert").filter(has_text="not the admin token")).to_be_visible()
        assert violations(page) == []
        page.get_by_label("Admin token").fill(admin_token(server))
        page.keyboard.press("Enter")
        expect(page.get_by_text("Late ticks (p99)")).to_be_visible()
        assert "token" not in page.url
        page.goto("/recordings")  # the same tab is not asked again
        expect(page.locator("#filters")).to_be_visible()


@pytest.mark.parametrize(
    ("path", "answer"),
    [("/admin", "/api/admin/state"), ("/recordings", "/api/recordings"), ("/annotate", "/api/findings")],
)
def test_a_page_says_that_it_loads_until_the_server_has_answered(
    server: Server, open_page: OpenPage, path: str, answer: str
) -> None:
    page = open_page("/healthz", locale="de")
    held: list[Route] = []
    page.route(f"**{answer}", lambda route: held.append(route))

    def let_go() -> None:
        while not held:
            page.wait_for_timeout(20)
        held.pop().continue_()

    page.goto(path)
    page.get_by_label("Admin-Token").fill(admin_token(server))
    page.get_by_role("button", name="Öffnen").click()
    loading = page.get_by_role("status").filter(has_text="Wird geladen …")
    expect(loading).to_be_visible()
    let_go()
    expect(loading).to_be_hidden()
    page.reload()  # with the token that is kept, nothing but this stands there
    expect(loading).to_be_visible()
    expect(page.get_by_label("Admin-Token")).to_have_count(0)
    let_go()
    expect(loading).to_be_hidden()


def test_a_new_room_appears_without_a_reload_and_closing_needs_a_yes(server: Server, open_page: OpenPage) -> None:
    page = open_page("/admin", script=unlocked(server))
    expect(page.locator("#facts")).to_be_visible()
    room = server.make_room("FourCorners", blue="link", red="idle")["room"]
    row = page.locator(f"[data-room='{room}']")
    expect(row).to_contain_text("Waiting for players")
    expect(row).to_contain_text("Four Corners")
    expect(row).to_contain_text("free seat")
    expect(row.get_by_role("link", name="Watch")).to_have_attribute("href", f"/watch/{room}")
    row.get_by_role("button", name="Close").click()
    page.get_by_role("button", name="Keep it open").click()
    expect(row).to_be_visible()
    row.get_by_role("button", name="Close").click()
    page.get_by_role("button", name="Close the room").click()
    expect(row).to_have_count(0)


def test_a_room_on_a_drawn_map_is_listed_with_its_title(server: Server, open_page: OpenPage) -> None:
    drawn = map_to_json(replace(load_map("LeftRight"), name="map-w2xkq", title="Grandma's kitchen"))
    seats = [{"kind": "here"}, {"kind": "agent", "agent": "idle"}]
    room = server.post("/api/rooms", {"maps": [], "map": drawn, "seats": seats})["room"]
    page = open_page("/admin", script=unlocked(server))
    expect(page.locator(f"[data-room='{room}']")).to_contain_text("Grandma's kitchen")


def test_all_rooms_of_an_address_are_closed_at_once(server: Server, open_page: OpenPage) -> None:
    seats = [{"kind": "link"}, {"kind": "agent", "agent": "idle"}]
    wanted = {"maps": ["FourCorners"], "seats": seats}  # without the operator's token, so that they are of an address
    rooms = [server.request("/api/rooms", wanted)["room"] for _ in range(2)]
    page = open_page("/admin", script=unlocked(server))
    page.locator(f"[data-room='{rooms[0]}']").get_by_role("button", name="Close").click()
    page.get_by_role("button", name="from this address").click()
    for room in rooms:
        expect(page.locator(f"[data-room='{room}']")).to_have_count(0)


def test_why_a_room_could_not_be_closed_stays_until_the_next_action(browser: Browser, server: Server) -> None:
    room = server.make_room("FourCorners", blue="link", red="idle")["room"]
    refusal = {"error": {"code": "fault", "message": "", "values": {}}}
    with complaining_page(browser, server, "") as page:
        page.add_init_script(unlocked(server))
        page.route("**/close", lambda route: route.fulfill(status=500, json=refusal))
        page.goto("/admin")
        close = page.locator(f"[data-room='{room}']").get_by_role("button", name="Close")
        close.click()
        page.get_by_role("button", name="Close the room").click()
        problem = page.get_by_role("alert").filter(has_text="Something went wrong")
        expect(problem).to_have_text("Something went wrong on the server. Please try again.")
        for _ in range(2):
            with page.expect_response("**/api/admin/state"):
                pass
        expect(problem).to_be_visible()
        close.click()
        expect(problem).to_have_count(0)


def test_the_keyboard_keeps_its_place_while_the_figures_change(server: Server, open_page: OpenPage) -> None:
    room = server.make_room("LeftRight", blue="link", red="idle")["room"]
    page = open_page("/admin", script=unlocked(server))
    close = page.locator(f"[data-room='{room}']").get_by_role("button", name="Close")
    close.focus()
    with page.expect_response("**/api/admin/state"):
        pass
    with page.expect_response("**/api/admin/state"):
        pass
    expect(close).to_be_focused()


def test_a_lost_server_is_said_the_last_figures_stay_and_its_return_is_noticed(
    browser: Browser, server: Server
) -> None:
    with complaining_page(browser, server, "") as page:
        page.add_init_script(unlocked(server))
        page.goto("/admin")
        expect(page.get_by_text("Late ticks (p99)")).to_be_visible()
        page.context.set_offline(True)
        expect(page.get_by_role("alert").filter(has_text="The server does not answer")).to_be_visible()
        expect(page.get_by_text("Late ticks (p99)")).to_be_visible()
        page.context.set_offline(False)
        expect(page.get_by_text("The server does not answer")).to_have_count(0)


def test_the_dashboard_is_accessible_in_both_themes(server: Server, open_page: OpenPage) -> None:
    server.make_room("HandOff", blue="link", red="idle")
    page = open_page("/admin", script=unlocked(server))
    expect(page.locator("[data-room]").first).to_be_visible()
    assert violations(page) == []


def test_the_dashboard_works_on_a_phone(server: Server, open_page: OpenPage) -> None:
    room = server.make_room("HandOff", blue="link", red="idle")["room"]
    page = open_page("/admin", script=unlocked(server), viewport=PHONE)
    close = page.locator(f"[data-room='{room}']").get_by_role("button", name="Close")
    close.tap() if page.evaluate("navigator.maxTouchPoints > 0") else close.click()
    expect(page.get_by_role("dialog")).to_be_visible()
    assert overflow(page) == 0
    page.get_by_role("button", name="Close the room").click()
    expect(page.locator(f"[data-room='{room}']")).to_have_count(0)


@pytest.mark.parametrize("width", [1110, pytest.param(1366, marks=pytest.mark.slow)])
def test_a_room_s_buttons_stay_in_their_card_in_german(server: Server, open_page: OpenPage, width: int) -> None:
    room = server.make_room("SequentialRotations", red="idle")
    start(open_page(room["join_path"], room))

    def with_reason(route: Route) -> None:
        state = route.fetch().json()
        for row in state["rooms"]:
            row.update(reason_code="not_back", reason_values={"players": ["blue", "red"]}, reason="Gone.")
        route.fulfill(json=state)

    page = open_page("/healthz", script=unlocked(server), viewport={"width": width, "height": 768})
    page.route("**/api/admin/state", with_reason)
    page.goto("/admin?lang=de")
    expect(page.locator(f"[data-room='{room['room']}']")).to_contain_text("ms")
    card = page.locator(".table-card").first
    assert card.evaluate("card => card.scrollWidth <= card.clientWidth")
    assert overflow(page) == 0


def test_recordings_are_listed_filtered_and_lead_to_their_replay(server: Server, open_page: OpenPage) -> None:
    folder = server.data / "recordings"
    for number, name in enumerate(("PriorityPick", "SingleRotation")):
        finalise(record(folder, ticks=5, map_name=name, episode_id=f"listed-{number}")[0])
    drawn = replace(load_map("LeftRight"), name="map-w2xkq", title="Grandma's kitchen")
    finalise(record(folder, ticks=5, map=drawn, episode_id="listed-2")[0])
    (folder / "broken.mcap").write_bytes(b"no recording")
    page = open_page("/recordings", script=unlocked(server))
    rows = page.locator("#rows tr")
    expect(rows.filter(has_text="Priority Pick")).to_have_count(1)
    expect(rows.filter(has_text="unreadable")).to_contain_text("broken")
    assert violations(page) == []
    page.get_by_label("Map").select_option(label="Grandma's kitchen")
    expect(rows).to_have_count(1)
    expect(rows).to_contain_text("Grandma's kitchen")
    page.get_by_label("Map").select_option("SingleRotation")
    expect(rows).to_have_count(1)
    expect(rows).to_contain_text("P-3f2a")
    rows.get_by_role("link", name="Replay").click()
    page.wait_for_url("**/replay/listed-1*")
    expect(page.get_by_role("heading", name="Single Rotation")).to_be_visible()


def test_the_list_of_recordings_is_readable_on_a_phone(server: Server, open_page: OpenPage) -> None:
    finalise(record(server.data / "recordings", ticks=5, map_name="HandOff", episode_id="on-a-phone")[0])
    page = open_page("/recordings", script=unlocked(server), viewport=PHONE, color_scheme="dark")
    expect(page.locator("#rows tr").first).to_be_visible()
    assert overflow(page) == 0
    assert violations(page) == []


def test_the_page_speaks_the_language_of_the_address(server: Server, open_page: OpenPage) -> None:
    page = open_page("/admin?lang=de", script=unlocked(server))
    expect(page.get_by_role("heading", name="Laufende Spiele")).to_be_visible()
    expect(page.get_by_text("Verspätete Ticks (p99)")).to_be_visible()
    assert violations(page) == []
