"""What policies from elsewhere have in common: a decision gives some ticks of actions, which are played in turn."""

from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from movingout.agents.action_chunk import MAX_ROWS
from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.errors import AgentError
from movingout.agents.grasp_encoding import toggles
from movingout.agents.observation.seat_observation import start_state
from movingout.maps import load_map
from movingout.world.action import GRASP_THRESHOLD, in_arena
from movingout.world.observation import LAYOUTS, encode_state
from movingout.world.state import Floats

Singles = npt.NDArray[np.float32]
TRIED_ON = "HandOff"  # the map whose first observation a policy is tried with when it is loaded
MOST_SAID = 300  # letters of what a library says
GRASPS = ("toggle", "hold")
HEADINGS = ("own", "arena")
ROW = "an action is 4 numbers: distance, cos and sin of the heading, grasp"


class ChunkPlayer(ABC):
    """Is asked every tick; decides when `execute` ticks of the last decision were played.

    `grasp` is what the fourth number means: `toggle`, the press of the grab button as recorded, or `hold`, whether the
    hand is to hold. `headings` is what headings are relative to: `arena`, or `own`, the robot's angle before the tick
    that they are played in; empty: `own` for layouts in the own frame, as in environments and exports.
    """

    layout: str
    execute_rows = 1  # rows beyond the first are there for a missed deadline

    def __init__(self, execute: int, grasp: str, headings: str = "") -> None:
        """`execute`: 0 plays a decision to its end. Raises AgentError."""
        if type(execute) is not int or not 0 <= execute <= MAX_ROWS:
            raise AgentError(f"execute is a whole number of ticks from 1 to {MAX_ROWS}, not {execute}")
        if grasp not in GRASPS:
            raise AgentError(f"unknown grasp {grasp!r}; known: {', '.join(GRASPS)}")
        if headings not in ("", *HEADINGS):
            raise AgentError(f"unknown headings {headings!r}; known: {', '.join(HEADINGS)}")
        self._execute = execute
        self._grasp = grasp
        self._headings = headings
        self._rows: Floats = np.empty((0, 4))
        self._begun = 0

    def reset(self, episode: EpisodeInfo) -> None:
        """Start an episode."""
        self.episode = episode
        self._rows = np.empty((0, 4))
        self._start()

    def act(self, observation: Observation) -> ActionChunk:
        """The rest of the last decision (h, 4). Raises AgentError for an answer that is no action."""
        self._see(observation)
        played = observation.tick - self._begun
        if not 0 <= played < min(self._execute or MAX_ROWS, len(self._rows)):
            self._rows, self._begun, played = rows_of(self._decide(observation)), observation.tick, 0
        return self._pressed(self._in_arena(self._rows[played:], observation), observation)

    def _start(self) -> None:  # noqa: B027 - most have no memory
        """Forget the previous episode."""

    def _see(self, observation: Observation) -> None:  # noqa: B027
        """Called in every tick, before a decision."""

    @abstractmethod
    def _decide(self, observation: Observation) -> npt.ArrayLike:
        """One action (4,), or several (H, 4)."""

    def _in_arena(self, rows: Floats, observation: Observation) -> Floats:
        """The rows with headings of the arena, as environments take them."""
        angle = float(observation.state.robot_poses[observation.seat, 2])
        return in_arena(rows, angle, (self._headings or LAYOUTS[self.layout].headings) == "own")

    def _pressed(self, rows: Floats, observation: Observation) -> Floats:
        """The rows as actions: distance in [-1, 1], and presses of the grab button, 0 or 1."""
        levels = rows[:, 3] > GRASP_THRESHOLD
        holding = bool(observation.state.held[observation.seat] >= 0)
        presses = levels if self._grasp == "toggle" else toggles(levels, holding)
        return np.column_stack((np.clip(rows[:, 0], -1.0, 1.0), rows[:, 1:3], presses))


class VectorPlayer(ChunkPlayer):
    """Decides from the last observations in one layout, (To, D)."""

    def __init__(self, layout: str, history: int, execute: int, grasp: str, headings: str = "") -> None:
        super().__init__(execute, grasp, headings)
        self.layout = layout
        self._history = history
        self._seen: list[Singles] = []

    def _start(self) -> None:
        self._seen = []

    def _see(self, observation: Observation) -> None:
        new = observation.encode(self.layout).astype(np.float32)
        self._seen = [*(self._seen or [new] * self._history)[1:], new]

    def _decide(self, observation: Observation) -> npt.ArrayLike:
        return self._infer(np.stack(self._seen))

    @abstractmethod
    def _infer(self, seen: Singles) -> npt.ArrayLike:
        """One action or several for observations (To, D)."""

    def _try(self, run: Callable[[Singles], npt.ArrayLike]) -> None:
        """Raises AgentError when the policy does not answer an observation that occurs, in its layout, with actions."""
        first = _first_observation(self.layout)
        try:
            answer = run(np.stack([first] * self._history))
        except Exception as error:  # whatever the runtime of a policy raises
            lines = str(error).strip().splitlines() or [type(error).__name__]
            whole = " ".join(" ".join(lines).split())
            said = whole if len(whole) <= MOST_SAID else lines[-1]  # the end of a traceback of torch
            raise AgentError(
                f"the policy does not take {self.layout} ({len(first)} numbers): {said[:MOST_SAID]}"
            ) from error
        rows_of(answer, f" the first observation of {TRIED_ON}")


def _first_observation(layout: str) -> Singles:
    """What blue sees first on a map: rows of zeros never occur, and what divides by their length has no answer."""
    tried_on = load_map(TRIED_ON)
    return encode_state(tried_on, start_state(tried_on), 0, layout).astype(np.float32)


def rows_of(answer: npt.ArrayLike, to: str = "") -> Floats:
    """An answer (4,), (H, 4) or (1, H, 4) as rows (H, 4). Raises AgentError for other shapes and other numbers."""
    rows = np.asarray(answer, dtype=np.float64)
    shape = rows.shape
    if rows.ndim == 1:
        rows = rows[None]
    if rows.ndim == 3 and len(rows) == 1:
        rows = rows[0]
    if rows.ndim != 2 or rows.shape[1] != 4 or not 1 <= len(rows) <= MAX_ROWS:
        raise AgentError(f"the policy answers with shape {shape}; {ROW}, (1, 4), or (1, H, 4) for H ticks")
    if not np.isfinite(rows).all():
        raise AgentError(f"the policy answers{to} with numbers that are not finite")
    return rows
