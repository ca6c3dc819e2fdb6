"""For whoever watches over servers: is it well, should it be sent people, and all its figures."""

from typing import Any

from fastapi import APIRouter, Depends
from fastapi.responses import Response

from movingout.server.api.authentication import admin
from movingout.server.monitoring.metrics import CONTENT_TYPE, metrics_text
from movingout.server.public_host import PublicHost


def health_routes(host: PublicHost) -> APIRouter:
    router = APIRouter()

    @router.get("/healthz")
    async def health(response: Response) -> dict[str, Any]:
        """503 when something does not work and will not by itself: restart it."""
        faults = host.faults()
        response.status_code = 503 if faults else 200
        return {"ok": not (host.stopping or faults), "rooms": host.room_count, "faults": faults}

    @router.get("/readyz")
    async def ready(response: Response) -> dict[str, Any]:
        """503 while no room can be opened: send people elsewhere."""
        reasons = host.why_not_ready()
        response.status_code = 503 if reasons else 200
        return {"ready": not reasons, "reasons": reasons}

    @router.get("/metrics", dependencies=[Depends(admin(host))])
    async def metrics() -> Response:
        return Response(await metrics_text(host), headers={"content-type": CONTENT_TYPE, "cache-control": "no-store"})

    return router
