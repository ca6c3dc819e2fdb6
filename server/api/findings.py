"""The API of the annotator's page: failure cases that rules found in recordings, and what annotators say about them."""

import asyncio
import csv
import hashlib
import io
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
from fastapi import APIRouter, Depends, Request
from fastapi.responses import Response

from movingout.recordings import RecordingError
from movingout.recordings.annotation.findings_table import finding_rows
from movingout.recordings.annotation.search import FailureSearch, search_failures
from movingout.recordings.annotation.verdicts import (
    VerdictLine,
    add_verdict,
    checked_annotator,
    new_line,
    newest,
    verdicts_of,
)
from movingout.recordings.spreadsheet import safe_cells
from movingout.server.api.authentication import admin, body_of
from movingout.server.api.errors import ApiError, unreadable
from movingout.server.public_host import PublicHost

SEARCH_S = 2.0  # per request; the page asks again until everything is searched


class VerdictRequest(msgspec.Struct, forbid_unknown_fields=True):
    """The body of POST /api/findings/verdicts."""

    finding: str
    verdict: str
    annotator: str
    note: str = ""


def routes(host: PublicHost) -> APIRouter:
    """All of them need the admin token: a finding says who failed, and verdicts are data of a study.

    Their handlers raise ApiError.
    """
    router = APIRouter(prefix="/api/findings", dependencies=[Depends(admin(host))])

    def folder() -> Path:
        return host.recording_service.folder

    async def searched(most_s: float) -> FailureSearch:
        try:
            return await host.recording_service.compute(partial(search_failures, folder(), most_s))
        except RecordingError as error:
            raise unreadable(error, 503, "no_recordings") from None

    @router.get("")
    async def findings() -> dict[str, Any]:
        search = await searched(SEARCH_S)
        return {
            "findings": sorted(_documents(search), key=_drawn_place),
            "searched": len(search.recordings) + search.left_out + search.copies,
            "remaining": search.remaining,
        }

    @router.get("/verdicts")
    async def verdicts(annotator: str) -> dict[str, Any]:
        """Only the annotator's own: nobody is led by what others said."""
        name = _named(annotator)
        lines = [line for line in await asyncio.to_thread(verdicts_of, folder()) if line.annotator == name]
        return {"verdicts": {line.finding: {"verdict": line.verdict, "note": line.note} for line in lines}}

    @router.post("/verdicts")
    async def say(request: Request) -> dict[str, bool]:
        body = await body_of(request, VerdictRequest)
        line = _checked_verdict(body, await searched(0.0))
        try:
            await asyncio.to_thread(add_verdict, folder(), line)
        except OSError as error:
            raise ApiError(507, "not_saved", f"The answer could not be saved: {error.strerror}.") from None
        return {"saved": True}

    @router.get("/annotations.csv")
    async def table() -> Response:
        search = await searched(0.0)
        lines = await asyncio.to_thread(verdicts_of, folder())
        headers = {"content-disposition": 'attachment; filename="annotations.csv"', "cache-control": "no-store"}
        return Response(_csv_text(search, lines), media_type="text/csv; charset=utf-8", headers=headers)

    return router


def _checked_verdict(body: VerdictRequest, search: FailureSearch) -> VerdictLine:
    """The verdict as it is kept. Raises ApiError for a finding that is not there, and for a verdict that is none."""
    known = {finding["id"]: finding for finding in _documents(search)}
    if body.finding not in known:
        raise ApiError(404, "no_finding", "There is no such finding; the recording may have been deleted.")
    try:
        return new_line(body.finding, body.verdict, _named(body.annotator), known[body.finding]["study"], body.note)
    except RecordingError as error:
        raise ApiError(422, "answer", str(error)) from None


def _csv_text(search: FailureSearch, lines: list[VerdictLine]) -> str:
    """The table of findings with the newest verdict of each annotator."""
    columns, rows = finding_rows(search.recordings, newest(lines))
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(map(safe_cells, rows))
    return text.getvalue()


def _documents(search: FailureSearch) -> Iterator[dict[str, Any]]:
    """What the page needs; no names, so that nobody judges a model by its name."""
    for recording in search.recordings:
        for finding in recording.findings:
            yield {
                "id": finding.id,
                "recording": recording.id,
                "study": recording.study,
                "map": recording.map,
                "case": finding.case,
                "seat": finding.seat,
                "item": finding.item,
                "start": finding.start,
                "end": finding.end,
                "human": recording.seats[finding.seat].kind == "human",
            }


def _drawn_place(finding: dict[str, Any]) -> bytes:
    """An order that mixes maps, cases and partners, and is the same for everybody."""
    return hashlib.sha256(str(finding["id"]).encode()).digest()


def _named(annotator: str) -> str:
    try:
        return checked_annotator(annotator)
    except RecordingError as error:
        raise ApiError(422, "annotator", str(error)) from None
