"""How often a node tries to begin the study before another one may. Pure: times are arguments, in seconds."""

TRIES = 3
PAUSE_S = 10.0  # for the others, which look once a second, to take the study
MOST_LETTERS = 500


class StudyTries:
    """`problem` says why the study is not served although this node had its lease; empty while it is, anywhere."""

    def __init__(self) -> None:
        self.problem = ""
        self._failed = 0
        self._not_before = float("-inf")

    def failed(self, why: str) -> None:
        self.problem = f"the study cannot begin here: {' '.join(why.split())}"[:MOST_LETTERS]
        self._failed += 1

    def went_well(self) -> None:
        """The study is open, here or at another node."""
        self.problem, self._failed = "", 0

    @property
    def used_up(self) -> bool:
        return self._failed >= TRIES

    def given_back(self, now: float) -> None:
        self._failed, self._not_before = 0, now + PAUSE_S

    def may_try(self, now: float) -> bool:
        return now >= self._not_before
