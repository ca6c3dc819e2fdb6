"""The novice: a greedy walker who makes a beginner's mistakes, fewer and fewer within the episode.

It lets go early, pulls to another place, presses twice, wanders off, and reacts late.
"""

from collections import deque
from random import Random

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.errors import AgentError
from movingout.agents.observation.seat_observation import observe
from movingout.agents.partners.greedy_walker import GreedyWalker
from movingout.agents.partners.walking import Point, goal_centres, walk
from movingout.agents.scripted.navigation.motion_choice import DriveCommand
from movingout.agents.scripted.perception import Perception
from movingout.world.state import WorldState

LEARNS_IN = 250  # ticks after which it makes half as many mistakes
DROPS = 0.02  # per tick of carrying: lets go too early
MISTAKES_GOAL = 0.5  # per item taken: pulls to somewhere else at first
PRESSES_TWICE = 0.4  # per press
WANDERS = 0.01  # per tick with empty hands
ASTRAY_FOR = (15, 45)  # ticks of pulling elsewhere or wandering
LATEST = 4  # ticks of reacting late at the beginning


class Novice(GreedyWalker):
    """A partner who learns while it plays. Deterministic given its options and the episode."""

    def __init__(self, seed: int = 0, learns_in: int = LEARNS_IN) -> None:
        """`learns_in`: ticks after which it makes half as many mistakes. Raises AgentError unless it is positive."""
        if not isinstance(learns_in, int) or learns_in < 1:
            raise AgentError(f"novice: learns_in is a whole number of ticks from 1, not {learns_in!r}")
        random = Random(f"novice/{seed}")
        super().__init__(seed, random.choice(("near", "light", "heavy")), random.randint(30, 80))
        self.learns_in = learns_in

    def reset(self, episode: EpisodeInfo) -> None:
        """Begin an episode as a beginner."""
        super().reset(episode)
        self._map, self._seat = episode.map, episode.seat
        self._mistakes = Random(f"novice/{self.seed}/{episode.seed}/{episode.seat}")
        self._seen: deque[WorldState] = deque(maxlen=LATEST + 1)
        self._astray_until, self._place = -1, (0.0, 0.0)
        self._presses_again = False
        self._had = -1

    def clumsiness(self, tick: int) -> float:
        """The share of its first mistakes that it still makes."""
        return self.learns_in / (self.learns_in + tick)

    def act(self, observation: Observation) -> ActionChunk:
        """A chunk of one row. Robots and items are seen late; what is in the own hand is felt at once."""
        self._seen.append(observation.state)
        late = self._seen[max(len(self._seen) - 1 - round(LATEST * self.clumsiness(observation.tick)), 0)]
        if late.held.tolist() != observation.state.held.tolist():
            late = observation.state
        return super().act(observe(self._map, late, self._seat, observation.tick))

    def command(self, now: Perception) -> DriveCommand:
        """What it does in this tick, mistakes included."""
        clumsy = self.clumsiness(now.tick)
        if self._presses_again:
            self._presses_again = False
            return DriveCommand(0.0, float(now.pose[2]), grasp=True)
        if now.own_item != self._had:
            self._had = now.own_item
            if now.own_item >= 0 and self._mistakes.random() < MISTAKES_GOAL * clumsy:
                self._go_astray(now)
        if now.own_item >= 0 and self._mistakes.random() < DROPS * clumsy:
            return DriveCommand(0.0, float(now.pose[2]), grasp=True)
        if now.own_item < 0 and self._mistakes.random() < WANDERS * clumsy:
            self._go_astray(now)
        if now.own_item < 0 and now.tick < self._astray_until:
            return walk(now, now.space(), [self._place])
        command = super().command(now)
        self._presses_again = command.grasp and self._mistakes.random() < PRESSES_TWICE * clumsy
        return command

    def targets(self, now: Perception) -> list[Point]:
        """Home, or for a while somewhere else."""
        return [self._place] if now.tick < self._astray_until else super().targets(now)

    def _go_astray(self, now: Perception) -> None:
        """Choose another place than what is nearest: another goal where there is one, or anywhere."""
        home = goal_centres(now.map)
        anywhere = (self._mistakes.uniform(-1.0, 1.0), self._mistakes.uniform(-1.0, 1.0))
        self._place = self._mistakes.choice([anywhere, *(home if len(home) > 1 else [])])
        self._astray_until = now.tick + self._mistakes.randint(*ASTRAY_FOR)
