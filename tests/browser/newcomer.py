"""Somebody who has never seen the game: does what the tutorial says, and knows only what is on the screen."""

import math
import time
from pathlib import Path
from typing import Any

SIGHT = (Path(__file__).parent / "sight.js").read_text(encoding="utf-8")  # defines window.__sight
NEAR = 0.13  # of the arena's side: own robot to what glows, when a grab is worth a try
PLAY_S = 150.0

Direction = tuple[float, float]  # right, down


class Newcomer:
    """Has eyes and hands; which ones, subclasses say."""

    def look(self) -> dict[str, Any]:
        """What sight.js sees."""
        raise NotImplementedError

    def push(self, direction: Direction = (0.0, 0.0), backward: bool = False) -> None:
        """Drive that way from now on, perhaps backward; (0, 0) stands still."""
        raise NotImplementedError

    def grab(self) -> None:
        """Stand still and grab or let go, not more often than a person would."""
        raise NotImplementedError

    def wait(self, seconds: float) -> None:
        time.sleep(seconds)

    def play(self) -> list[str]:
        """Do what the words say until the tutorial is over; returns the words in their order."""
        heard: list[str] = []
        seen: dict[str, Any] = {}
        deadline = time.monotonic() + PLAY_S
        while time.monotonic() < deadline:
            seen = self.look()
            if seen["end"]:
                self.push()
                return heard
            if seen["words"] not in heard[-1:]:
                heard.append(seen["words"])
            self.follow(seen)
            self.wait(0.06)
        raise AssertionError(f"not finished: {heard}, {seen}")

    def follow(self, seen: dict[str, Any]) -> None:
        words, me, glow, home = seen["words"], seen["me"], seen["glow"], seen["home"]
        if "backward" in words:
            self.push((0.0, 1.0), backward=True)
        elif ("Grab" in words or "press" in words) and glow["count"] > 20:
            dx, dy = glow["x"] - me["x"], glow["y"] - me["y"]
            self.push((dx, dy))
            if math.hypot(dx, dy) < NEAR + (0.06 if " 2 " in words else 0.0):
                self.grab()
        elif "green" in words and me["y"] < home["bottom"]:
            self.push()
            self.grab()
        elif "green" in words or "home" in words:
            self.push((0.0, -1.0))
        elif glow["count"] > 20:
            self.push((glow["x"] - me["x"], glow["y"] - me["y"]))
        else:
            self.push()
