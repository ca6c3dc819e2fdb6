"""Links that only the experimenter can make: an id, an expiry, and a signature over both and the study."""

import hashlib
import hmac
import re
from base64 import urlsafe_b64encode
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple
from urllib.parse import urlencode

from movingout.maps.files.ownership import make_folder
from movingout.server.security.kept_secret import kept_secret
from movingout.study.errors import StudyError

KEY_FILE = "link-key"  # in the folder of the study
LETTERS = 22  # of the signature: 132 bits
_ID = re.compile(r"[A-Za-z0-9._-]{1,64}")


class SignedId(NamedTuple):
    """Whom a link is for."""

    id: str
    expired: bool


class LinkSigner:
    """Makes and checks the links of one study. Times are seconds since the epoch."""

    def __init__(self, key: str, study: str) -> None:
        self._key = key.encode()
        self._study = study

    @classmethod
    def in_folder(cls, own: Path, study: str) -> "LinkSigner":
        """With the key of a study's folder, made if there is none. Raises StudyError.

        A key of no use is not replaced: every link that was given out would end.
        """
        try:
            make_folder(own)
            key = kept_secret(own / KEY_FILE, replace=False)
        except OSError as error:
            raise StudyError(f"cannot keep the key of links in {own / KEY_FILE}: {error.strerror}") from None
        if not key:
            raise StudyError(
                f"the key of links in {own / KEY_FILE} is damaged, belongs to somebody else, or can be read by others; "
                "run this as the user that the server runs as, and let nobody else read the file (chmod 600). Deleting "
                "it ends all links that were made"
            )
        return cls(key, study)

    def query(self, id: str, until: int) -> str:
        """The parameters of a link: "id=...&until=...&sig=...". Raises StudyError for an id that does not fit."""
        if not _ID.fullmatch(id):
            raise StudyError(f"an id has up to 64 letters, digits, dots and dashes, not {id!r}")
        return urlencode({"id": id, "until": until, "sig": self._signature(id, str(until))})

    def checked(self, given: Mapping[str, str], now: float) -> SignedId | None:
        """Whom the link is for, None when it is not one of ours or was changed."""
        id, until, signature = (given.get(name, "") for name in ("id", "until", "sig"))
        if not _ID.fullmatch(id) or not re.fullmatch(r"[0-9]{1,12}", until):
            return None
        if not hmac.compare_digest(signature.encode(), self._signature(id, until).encode()):
            return None
        return SignedId(id, now > int(until))

    def _signature(self, id: str, until: str) -> str:
        message = "\n".join(("movingout-link-1", self._study, id, until))
        digest = hmac.digest(self._key, message.encode(), hashlib.sha256)
        return urlsafe_b64encode(digest).decode()[:LETTERS]
