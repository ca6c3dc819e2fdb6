"""The pages and their static files, served from web/ and always revalidated, so that a new version shows at once."""

from pathlib import Path

from fastapi import APIRouter
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response
from starlette.types import Receive, Scope, Send
from starlette.websockets import WebSocketClose

from movingout.server.api.static_files import StaticCache

WEB = Path(__file__).parents[2] / "web"
SERVED = frozenset({".js", ".css", ".svg", ".png", ".ico", ".woff2", ".webmanifest"})

router = APIRouter(include_in_schema=False)
_files = StaticCache(WEB)


class StaticModules:
    """Serves the files that pages consist of, and nothing else in the folder."""

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "websocket":
            await WebSocketClose()(scope, receive, send)
            return
        if scope["method"] not in ("GET", "HEAD"):
            raise HTTPException(405)
        path = scope["path"].removeprefix(scope.get("root_path", "")).lstrip("/")
        words = path.startswith("words/") and path.endswith(".json")
        if not words and (Path(path).suffix not in SERVED or path.startswith("tests")):
            raise HTTPException(404)
        response = _files.response(path, Request(scope))
        if response is None:
            raise HTTPException(404)
        await response(scope, receive, send)


def page(name: str, status: int = 200) -> Response:
    """One of the pages. Raises FileNotFoundError when it is not there."""
    response = _files.response(name, status=status)
    if response is None:
        raise FileNotFoundError(f"the page {name} is missing from {WEB}")
    return response


def missing() -> Response:
    """The page for an unknown address."""
    return page("404.html", 404)


@router.get("/")
async def lobby() -> Response:
    return page("lobby/index.html")


@router.get("/play/{room}")
@router.get("/watch/{room}")
async def play(room: str) -> Response:
    return page("play/play.html")


@router.get("/practice")
async def practice() -> Response:
    return page("lobby/index.html")


@router.get("/recordings")
async def recordings() -> Response:
    return page("replay/recordings.html")


@router.get("/replay/{episode}")
async def replay(episode: str) -> Response:
    return page("replay/replay.html")


@router.get("/annotate")
async def annotate() -> Response:
    return page("annotate/annotate.html")


@router.get("/admin")
async def admin() -> Response:
    return page("admin/admin.html")


@router.get("/favicon.ico")
async def icon() -> Response:
    return page("icon.svg")
