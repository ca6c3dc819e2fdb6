"""Who opens the link: parameters of a recruitment platform, a code, or nothing at all."""

import secrets
from collections.abc import Mapping
from typing import NamedTuple

from study.errors import StudyError

PROLIFIC, MTURK, CODE, LINK = "prolific", "mturk", "code", "link"
PREVIEW = "ASSIGNMENT_ID_NOT_AVAILABLE"  # what MTurk sends while somebody only looks
MOST_LETTERS = 200  # of a parameter
KEPT = ("STUDY_ID", "SESSION_ID", "assignmentId", "hitId")  # to find an assignment again when paying


class Arrival(NamedTuple):
    """What a link says."""

    source: str
    external_id: str
    parameters: Mapping[str, str]
    screen: str  # the same for two people who share one screen, else empty


class NotWelcome(StudyError):
    """Somebody who cannot take part with this link; `code` is for programs."""

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code


def read_arrival(given: Mapping[str, str], needs_code: bool) -> Arrival:
    """Raises NotWelcome when the link cannot be a participant's."""
    if any(len(value) > MOST_LETTERS for value in given.values()):
        raise NotWelcome("link", "This link is not complete. Please open it again from where you got it.")
    kept = {name: given[name] for name in KEPT if given.get(name)}
    screen = given.get("screen", "")
    if given.get("PROLIFIC_PID"):
        return Arrival(PROLIFIC, given["PROLIFIC_PID"], kept, screen)
    if given.get("assignmentId") == PREVIEW:
        raise NotWelcome("preview", "This is a preview. Please accept the task first, then open it again.")
    if given.get("workerId"):
        return Arrival(MTURK, given["workerId"], kept, screen)
    code = given.get("code", "").strip().upper()
    if code:
        return Arrival(CODE, code, kept, screen)
    if needs_code:
        raise NotWelcome("code", "Please type the code that you were given.")
    return Arrival(LINK, secrets.token_urlsafe(16), kept, screen)
