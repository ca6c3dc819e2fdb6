"""The routes of the experimenter's page; all of them need the admin token."""

import csv
import io
from collections.abc import Awaitable, Callable
from typing import Annotated, Any

import segno
from fastapi import APIRouter, Depends, Query, Request
from fastapi.responses import Response, StreamingResponse

from movingout.recordings.spreadsheet import ENCODING
from movingout.server.api.authentication import admin, body_of
from movingout.server.study.api.dashboard import Dashboard
from movingout.server.study.api.event_stream import event_stream, every_second
from movingout.server.study.experimenter_actions import PAYMENT_COLUMNS, ExperimenterActions, ExperimenterRequest
from movingout.server.study.running_study import RunningStudy

LONGEST_CODE = 200  # letters; a QR code has no room for any number of them
NO_STORE = {"cache-control": "no-store"}


def routes(running: RunningStudy, experimenter: ExperimenterActions, dashboard: Dashboard) -> APIRouter:
    router = APIRouter(prefix="/api/experimenter", dependencies=[Depends(admin(running.host))])

    @router.get("/state")
    async def state() -> Response:
        return Response(await dashboard.newest(), media_type="application/json", headers=NO_STORE)

    @router.get("/live")
    async def live() -> StreamingResponse:
        return event_stream(every_second(running, dashboard))

    actions: dict[str, Callable[[ExperimenterRequest], Awaitable[None]]] = {
        "pause": experimenter.pause,
        "resume": experimenter.resume,
        "restart-round": experimenter.restart_round,
        "kick": experimenter.kick,
        "invalid": experimenter.invalid,
        "valid": experimenter.valid,
        "note": experimenter.note,
        "allow-device": experimenter.allow_device,
    }
    for name, action in actions.items():
        router.add_api_route(f"/{name}", _handler(action), methods=["POST"])

    @router.post("/open-next")
    @router.post("/next-code")
    async def open_next(request: Request) -> dict[str, str]:
        return await experimenter.open_next(await body_of(request, ExperimenterRequest))

    @router.get("/qr.svg")
    async def qr(request: Request, code: Annotated[str, Query(max_length=LONGEST_CODE)]) -> Response:
        address = str(request.base_url.replace(path="/study", query="")) + f"?code={code}"
        return Response(_qr_code(address), media_type="image/svg+xml", headers=NO_STORE)

    @router.get("/payments.csv")
    async def payments() -> Response:
        file = _payments_csv(await experimenter.payments())
        return Response(file, media_type="text/csv; charset=utf-8", headers=NO_STORE)

    return router


def _qr_code(address: str) -> bytes:
    """An SVG with its namespace: the page shows it in an <img>."""
    picture = io.BytesIO()
    segno.make(address, error="m").save(picture, kind="svg", border=2, scale=4, dark="#000", light="#fff")
    return picture.getvalue()


def _payments_csv(rows: list[dict[str, Any]]) -> bytes:
    """A table with PAYMENT_COLUMNS, in the encoding that spreadsheets expect."""
    text = io.StringIO()
    writer = csv.DictWriter(text, PAYMENT_COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue().encode(ENCODING)


def _handler(
    action: Callable[[ExperimenterRequest], Awaitable[None]],
) -> Callable[[Request], Awaitable[dict[str, Any]]]:
    async def perform(request: Request) -> dict[str, Any]:
        await action(await body_of(request, ExperimenterRequest))
        return {"done": True}

    return perform
