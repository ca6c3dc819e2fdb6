"""The parameters of a participant's link: from a recruitment platform, a code, or none."""

import secrets
import time
from collections.abc import Mapping
from typing import NamedTuple
from urllib.parse import unquote

from movingout.server.notices import ErrorCode
from movingout.server.study.arrivals.signed_links import LinkSigner
from movingout.study.errors import StudyError
from movingout.study.store.database import NUL
from movingout.study.store.identity import CODE

PROLIFIC, MTURK, LINK, SIGNED = "prolific", "mturk", "link", "signed"
PLATFORMS = (PROLIFIC, MTURK)
INVITED = (CODE, SIGNED)
PREVIEW = "ASSIGNMENT_ID_NOT_AVAILABLE"  # what MTurk sends in a preview
UNFILLED = "{{%"  # a placeholder of Prolific in a link that was copied by hand: {{%PROLIFIC_PID%}}
MAX_LENGTH = 200  # letters of a parameter
SIGNED_WITH = ("id", "until")  # and `sig`
PERSONS = ("PROLIFIC_PID", "workerId")  # whom a platform sends
KEPT = ("STUDY_ID", "SESSION_ID", "assignmentId", "hitId")  # to find the assignment when paying


class Arrival(NamedTuple):
    """The contents of a link."""

    source: str
    external_id: str
    parameters: Mapping[str, str]
    expired: bool = False  # nobody may begin with it any more; who has begun may go on


class ArrivalRefused(StudyError):
    """Nobody can take part with this link; `code` tells the page why."""

    def __init__(self, code: ErrorCode, message: str) -> None:
        super().__init__(message)
        self.code = code


def read_arrival(
    link: Mapping[str, str], needs_code: bool, signer: LinkSigner | None = None, needs_signature: bool = False
) -> Arrival:
    """Raises ArrivalRefused for a link that no participant can have.

    Where a signature is needed, a code does as well: only the experimenter can make either.
    """
    given = {name: value.strip() for name, value in link.items()}
    if not all(map(_possible, given.values())):
        raise _incomplete()
    if given.get("assignmentId") == PREVIEW:
        raise ArrivalRefused("preview", "This is a preview. Please accept the task first, then open it again.")
    if given.get("sig") or (needs_signature and not (needs_code or given.get("code"))):
        return _signed(given, signer)
    source, external_id = _person(given, needs_code or needs_signature)
    if source == LINK and any(name in given for name in SIGNED_WITH):
        return _signed(
            given, signer
        )  # its end was lost in a message; as somebody without an id they would be paid twice
    if source == LINK and any(name in given for name in (*PERSONS, *KEPT)):
        raise _incomplete()  # a platform's, without its person: nobody could pay them, nor tell that they came before
    return Arrival(source, external_id, {name: given[name] for name in KEPT if given.get(name)})


def _incomplete() -> ArrivalRefused:
    return ArrivalRefused("link", "This link is not complete. Please open it again from where you got it.")


def _possible(value: str) -> bool:
    unfilled = unquote(value).startswith(UNFILLED)  # it may have been encoded twice
    return len(value) <= MAX_LENGTH and not unfilled and NUL not in value


def _signed(given: Mapping[str, str], signer: LinkSigner | None) -> Arrival:
    checked = signer.checked(given, time.time()) if signer is not None else None
    if checked is None:
        raise _incomplete()
    return Arrival(SIGNED, checked.id, {}, checked.expired)


def _person(given: Mapping[str, str], needs_code: bool) -> tuple[str, str]:
    """The source and the id there. Where a code is needed, nothing else is accepted."""
    code = given.get("code", "").upper().replace(" ", "").replace("-", "")
    if needs_code and not code:
        raise ArrivalRefused("code", "Please type the code that you were given.")
    if not needs_code and given.get("PROLIFIC_PID"):
        return PROLIFIC, given["PROLIFIC_PID"]
    if not needs_code and given.get("workerId"):
        return MTURK, given["workerId"]
    return (CODE, code) if code else (LINK, secrets.token_urlsafe(16))
