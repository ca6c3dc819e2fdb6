"""A state in words, for language models and people: what `observation.describe()` gives, as JSON and as text."""

import math
from dataclasses import dataclass
from typing import Any

from movingout.maps import MapSpec, Rect
from movingout.maps.spec import SEAT_COLOURS
from movingout.world.constants import TICK_SECONDS
from movingout.world.distance import paper_distances
from movingout.world.scoring import delivered_items
from movingout.world.state import WorldState

_SIDES = ("up", "up-left", "left", "down-left", "down", "down-right", "right", "up-right")


@dataclass(frozen=True, slots=True)
class Description:
    """A state as one seat knows it: `str()` gives text, `to_json()` plain values.

    Lengths are in units of the arena, which goes from -1.2 to 1.2 in both directions; y points up.
    """

    facts: dict[str, Any]

    def to_json(self) -> dict[str, Any]:
        """Plain values, as json.dumps takes them."""
        return self.facts

    def __str__(self) -> str:
        return _in_words(self.facts)


def described(map_spec: MapSpec, state: WorldState, seat: int) -> Description:
    """The state as `seat` knows it."""
    return Description(
        {
            "tick": state.tick,
            "seconds": round(state.tick * TICK_SECONDS, 1),
            "map": map_spec.name,
            "you": _robot(state, seat),
            "partner": _robot(state, 1 - seat),
            "items": _items(map_spec, state, seat),
            "goals": [_sides(box) for box in map_spec.goals],
            "walls": [_sides(box) for box in map_spec.walls],
        }
    )


def _items(map_spec: MapSpec, state: WorldState, seat: int) -> list[dict[str, Any]]:
    delivered = delivered_items(map_spec, state.item_poses).tolist()
    distances = paper_distances(map_spec)
    items = []
    for index, (item, pose) in enumerate(zip(map_spec.items, state.item_poses.tolist(), strict=True)):
        own, to_goal = state.robot_poses[seat, :2], float(distances.one_to_goal(state.item_poses[index, :2]))
        items.append(
            {
                "item": index,
                "shape": item.shape,
                "size": item.size,
                "needs_two": item.size != "small",
                "x": _rounded(pose[0]),
                "y": _rounded(pose[1]),
                "delivered": delivered[index],
                "held_by": [_who(holder, seat) for holder in (seat, 1 - seat) if state.held[holder] == index],
                "from_you": round(math.hypot(pose[0] - own[0], pose[1] - own[1]), 2),
                "way_to_goal": round(to_goal, 2) if math.isfinite(to_goal) else None,
            }
        )
    return items


def _sides(box: Rect) -> list[float]:
    return [_rounded(side) for side in (box.left, box.bottom, box.right, box.top)]


def _rounded(value: float) -> float:
    return round(value, 2) + 0.0  # 0.0 for -0.0


def _in_words(told: dict[str, Any]) -> str:
    you, partner = told["you"], told["partner"]
    done, total = sum(item["delivered"] for item in told["items"]), len(told["items"])
    lines = [
        f"{told['map']}, {told['seconds']} s. You are {you['colour']}; {done} of {total} items are delivered.",
        *(_robot_line(name, robot) for name, robot in (("You", you), ("Your partner", partner))),
    ]
    for item in told["items"]:
        who = " and ".join(item["held_by"])
        where = "delivered" if item["delivered"] else f"held by {who}" if who else f"{item['from_you']} from you"
        goal = "" if item["delivered"] or item["way_to_goal"] is None else f", {item['way_to_goal']} from a goal"
        two = ", heavy: carry it with two" if item["needs_two"] else ""
        lines.append(
            f"Item {item['item']}: {item['size']} {item['shape']} at ({item['x']}, {item['y']}), {where}{goal}{two}."
        )
    for name in ("Goals", "Walls"):
        if boxes := told[name.lower()]:
            lines.append(f"{name} (left, bottom, right, top): {'; '.join(str(tuple(box)) for box in boxes)}.")
    return "\n".join(lines)


def _robot(state: WorldState, robot: int) -> dict[str, Any]:
    x, y, angle = state.robot_poses[robot].tolist()
    held = int(state.held[robot])
    return {
        "colour": SEAT_COLOURS[robot],
        "x": _rounded(x),
        "y": _rounded(y),
        "looks": _SIDES[round(angle / (math.pi / 4)) % 8],
        "holds": None if held < 0 else held,
    }


def _robot_line(name: str, robot: dict[str, Any]) -> str:
    verb, has = ("are", "hold") if name == "You" else ("is", "holds")
    held = "nothing" if robot["holds"] is None else f"item {robot['holds']}"
    return f"{name} {verb} at ({robot['x']}, {robot['y']}), looking {robot['looks']}, and {has} {held}."


def _who(holder: int, seat: int) -> str:
    return "you" if holder == seat else "your partner"
