"""How many agents the workers can take: by what a decision costs, as measured, and by how many came too late.

Costs are shares of one core. They are kept in a file, so that nobody is admitted by a guess after a restart.
"""

import json
import logging
import math
import os
import threading
from collections.abc import Callable
from pathlib import Path

from movingout.agents.checkpoint.checkpoint import fingerprint
from movingout.maps import MapSpec, is_reserved

log = logging.getLogger(__name__)

MOST_PER_WORKER = 0.8  # share of a core; the rest absorbs decisions that fall together
ROOMS = 0.7  # of one core, for the rooms themselves
GUESS, GUESS_TRAINED = 0.03, 0.1  # assumed until measured: more than BASS takes (0.06 on a 2 GHz core)
WEIGHT = 0.05  # of one decision in the running average
ONE_ADDRESS = 0.5  # of the capacity that one address may take
BESIDE_STUDY = 0.5  # of the capacity that rooms outside of a running study may take
MOST_LATE = 0.1  # share of late decisions above which a worker takes no more seats
LATE_OF = 50  # decisions that this share is of, at least
HALF_LIFE_S = 10.0
MOST_KEPT = 200  # agents, of which each set of options makes another one; then the oldest is forgotten
COSTS, COSTS_S = "agent_costs.json", 60.0  # where costs are kept, and how often: a killed server keeps none at its end
_ON_OWN_MAPS = " on own maps"
_MANY_WALLS = 16, 32  # the twelve maps have up to 4; among 64, a decision of BASS takes three times as long


def per_worker(workers: int, cores: int | None = None) -> float:
    """The share of a core that the seats of one of so many workers may use, so that the rooms keep theirs."""
    cores = cores or usable_cores()
    return min(MOST_PER_WORKER, max(0.3, (cores - ROOMS) / max(1, workers)))


def usable_cores() -> int:
    """The cores that this process may use; where the system cannot tell (macOS), all."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def cost_name(agent_id: str, map_spec: MapSpec) -> str:
    """What the cost of an agent on a map is kept by: its id, and other names on maps that people made, by their walls.

    Many walls make a decision long, which says nothing of other maps.
    """
    if is_reserved(map_spec.name):
        return agent_id
    passed = [most for most in _MANY_WALLS if len(map_spec.walls) > most]
    return agent_id + _ON_OWN_MAPS + (f", more than {passed[-1]} walls" if passed else "")


class AgentCosts:
    """The share of a core that one seat of an agent uses, by `cost_name`. `file` is where it is kept, if anywhere."""

    def __init__(self, file: Path | None = None) -> None:
        self._file = file
        self._shares: dict[str, float] = {}
        self._prints: dict[str, str] = {}
        self._changed = False
        self._saving = threading.Lock()
        self._read()

    def of(self, name: str) -> float:
        """On maps of one's own that of other maps until it was measured there."""
        guess = GUESS_TRAINED if "@" in name else GUESS
        return self._shares.get(name, self._shares.get(_agent(name), guess))

    def known(self) -> dict[str, float]:
        """What was measured, here or before; nothing that is assumed."""
        return self._shares.copy()

    def take_over(self, shares: dict[str, float]) -> None:
        """Know what another process has measured, which keeps the file, instead of what was known here."""
        self._shares = shares.copy()
        self._prints = {name: seen for name, seen in self._prints.items() if name in shares}

    def measured(self, name: str, share: float) -> None:
        """Decisions of an agent were timed when it sat down; 0 for none. What was learned while it played stays."""
        if share > 0.0 and (name not in self._shares or self._prints.get(name) != _print(name)):
            self._set(name, share)

    def note(self, name: str, share: float) -> None:
        """One decision of an agent that plays. The first may include one-off planning, so it too counts little."""
        self._set(name, (1.0 - WEIGHT) * self.of(name) + WEIGHT * share)

    def save(self) -> None:
        """Write the file if anything has changed; a cost that cannot be kept is measured again. May run in a thread."""
        with self._saving:  # at the end of a server the thread may still be at it, with the same temporary file
            if self._file is not None and self._changed:
                self._write(self._file)

    def _write(self, file: Path) -> None:
        self._changed = False  # first, and of copies, as seats note costs meanwhile
        shares, prints = self._shares.copy(), self._prints.copy()
        rows = {name: {"share": round(share, 5), "model": prints.get(name, "")} for name, share in shares.items()}
        new = file.with_suffix(".tmp")
        try:
            new.write_text(json.dumps(rows, indent=1), encoding="utf-8")
            new.replace(file)
        except OSError as error:
            self._changed = True
            log.warning("the costs of agents are not kept in %s: %s", file, error.strerror)

    def _set(self, name: str, share: float) -> None:
        if name not in self._prints:
            self._prints[name] = _print(name)
        self._shares[name] = share
        self._changed = True
        if len(self._shares) > MOST_KEPT:
            oldest = next(iter(self._shares))
            del self._shares[oldest]
            self._prints.pop(oldest, None)

    def _read(self) -> None:
        try:
            rows = json.loads(self._file.read_text(encoding="utf-8")) if self._file else {}
            for name, row in rows.items():
                share, model = float(row["share"]), str(row["model"])
                if math.isfinite(share) and 0.0 < share < 1e3 and model == _print(name):
                    self._shares[name], self._prints[name] = share, model
        except FileNotFoundError:
            pass
        except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
            log.warning("%s is not read, and its costs are measured again: %s", self._file, error)


def _agent(name: str) -> str:
    return name.rpartition(_ON_OWN_MAPS)[0] or name


def _print(name: str) -> str:
    return fingerprint(_agent(name))


class LateDecisions:
    """The share of a worker's decisions that came too late in the last seconds."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._at = clock()
        self._all = self._late = 0.0

    def note(self, late: bool) -> None:
        self._fade()
        self._all += 1.0
        self._late += late

    def too_many(self) -> bool:
        self._fade()
        return self._late > MOST_LATE * max(self._all, LATE_OF)

    def _fade(self) -> None:
        now = self._clock()
        kept = 0.5 ** ((now - self._at) / HALF_LIFE_S)
        self._at, self._all, self._late = now, self._all * kept, self._late * kept
