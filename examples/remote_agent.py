"""A program that takes a seat, fetches one item and delivers it: states in, actions out, by `movingout.remote.Client`.

    python examples/remote_agent.py http://127.0.0.1:8000 ROOM

Create a room with a seat for a program, on the map Simple. For programs in other languages, docs/protocol.md explains
what a `Client` sends and hears.
"""

import asyncio
import math
import sys

from movingout.remote import Client, RemoteError
from movingout.world.state import WorldState

REACH = 0.195  # [u] from which an item can be grabbed by a robot that looks at it
HOMES = (-0.9, 0.8), (0.9, 0.8)  # where blue and red bring their item [u]


class Carrier:
    """Fetches `item`, brings it `home` and lets go."""

    def __init__(self, seat: int, item: int, home: tuple[float, float]) -> None:
        self.seat, self.item, self.home = seat, item, home
        self.done = False
        self._pressed_at = -10  # tick

    def act(self, state: WorldState) -> list[float]:
        """The action in a state: distance, cos and sin of the heading, grasp toggle. Heading 0 looks up."""
        carrying = int(state.held[self.seat]) == self.item
        x, y, angle = state.robot_poses[self.seat]
        to_x, to_y = self.home if carrying else state.item_poses[self.item, :2]
        away, heading = math.hypot(to_x - x, to_y - y), math.atan2(x - to_x, to_y - y)
        looks_at_it = abs(math.remainder(heading - angle, 2 * math.pi)) < 0.1
        there = away < 0.05 if carrying else away < REACH and looks_at_it
        press = there and state.tick > self._pressed_at + 2  # a press is seen in the next state
        if press:
            self._pressed_at = state.tick
            self.done = carrying
        forward = 0.0 if there else 0.005 if away < REACH and not carrying else min(1.0, away / 0.12)
        return [forward, math.cos(heading), math.sin(heading), float(press)]


async def main(server: str, room: str) -> None:
    async with Client(server, room, name="example") as client:
        carrier = Carrier(client.seat, item=client.seat, home=HOMES[client.seat])
        async for observation in client.observations():  # the newest state, ten a second
            if carrier.done and observation.state.held[client.seat] != carrier.item:
                return
            client.act([carrier.act(observation.state)])  # one row per tick to come


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    try:
        asyncio.run(main(*sys.argv[1:]))
    except RemoteError as error:
        sys.exit(str(error))
