"""The pages and their static files, served from web/ and always revalidated, so that a new version shows at once."""

from pathlib import Path

from fastapi import APIRouter
from starlette.exceptions import HTTPException
from starlette.responses import FileResponse, Response
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

WEB = Path(__file__).parents[2] / "web"
SERVED = frozenset({".js", ".css", ".svg", ".png", ".ico", ".woff2", ".webmanifest"})
NO_CACHE = {"cache-control": "no-cache"}

router = APIRouter(include_in_schema=False)


class StaticModules(StaticFiles):
    """Serves the files that pages consist of, and nothing else in the folder."""

    async def get_response(self, path: str, scope: Scope) -> Response:
        words = path.startswith("words/") and path.endswith(".json")
        if not words and (Path(path).suffix not in SERVED or path.startswith("tests")):
            raise HTTPException(404)
        response = await super().get_response(path, scope)
        response.headers.update(NO_CACHE)
        return response


def page(name: str) -> FileResponse:
    return FileResponse(WEB / name, headers=NO_CACHE)


def missing() -> FileResponse:
    """The page for an unknown address."""
    return FileResponse(WEB / "404.html", 404, headers=NO_CACHE)


@router.get("/")
async def lobby() -> FileResponse:
    return page("lobby/index.html")


@router.get("/play/{room}")
@router.get("/watch/{room}")
async def play(room: str) -> FileResponse:
    return page("play/play.html")


@router.get("/practice")
async def practice() -> FileResponse:
    return page("lobby/index.html")


@router.get("/recordings")
async def recordings() -> FileResponse:
    return page("replay/recordings.html")


@router.get("/replay/{episode}")
async def replay(episode: str) -> FileResponse:
    return page("replay/replay.html")


@router.get("/admin")
async def admin() -> FileResponse:
    return page("admin/admin.html")


@router.get("/favicon.ico")
async def icon() -> FileResponse:
    return page("icon.svg")
