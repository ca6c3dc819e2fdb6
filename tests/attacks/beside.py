"""Honest rooms beside a flood that runs in a process of its own."""

import asyncio
import sys
from typing import Any

from movingout.server.commands.loadtest import RunningServer, measure, open_room


def measured(target: RunningServer, flood: str, rooms: int, seconds: float) -> dict[str, Any]:
    """The fields of the load test, with two clients in each room; `flood` is empty for none."""

    room = open_room(target, "Simple", 2) if flood else ""  # while there is nothing else to do

    async def attack(server: RunningServer) -> None:
        arguments = ["-m", "tests.attacks.floods", flood, server.base, room]
        process = await asyncio.create_subprocess_exec(sys.executable, *arguments)
        try:
            await process.wait()
        finally:
            if process.returncode is None:
                process.kill()

    return measure(target, rooms, 2, seconds, beside=attack if flood else None)
