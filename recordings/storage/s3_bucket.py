"""Finished recordings in a bucket of an S3-compatible store (extra `s3`).

Credentials and the endpoint come from the environment alone: AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, AWS_REGION,
AWS_ENDPOINT_URL, or the role of the machine.
"""

import hashlib
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import timedelta
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from movingout.maps.extras import needs_extra
from movingout.maps.files.output_file import draft_of
from movingout.recordings.errors import RecordingError, cannot
from movingout.recordings.storage.finished import SUFFIX
from movingout.recordings.storage.listing import misnamed
from movingout.recordings.text_lines import append_line

UPLOADED_TO = "uploaded-to"  # in the data folder: the addresses, one a line, whose copies are deleted with a recording
DELETED = "deleted-recordings"  # beside it: names, one a line, that are in no bucket, whatever was being sent then
CHECK = "movingout-check"  # the object by which the right to write is tried
_ADDRESS = re.compile(r"s3://([A-Za-z0-9][A-Za-z0-9._-]{1,62})(?:/([A-Za-z0-9!_.*'()/-]*))?")
_MD5 = re.compile(r"[0-9a-f]{32}")


class S3Address(NamedTuple):
    """`s3://BUCKET/PREFIX`; the prefix has no slash at its ends."""

    bucket: str
    prefix: str

    def __str__(self) -> str:
        return f"s3://{self.bucket}/{self.prefix}".rstrip("/")


def s3_address(text: str) -> S3Address:
    """Raises RecordingError."""
    found = _ADDRESS.fullmatch(text)
    prefix = (found[2] or "").strip("/") if found else ""
    if found is None or any(part in ("", ".", "..") for part in prefix.split("/") if prefix):
        raise RecordingError(f"{text!r} is no address of a bucket; it looks like s3://bucket/folder")
    return S3Address(found[1], prefix)


class S3Bucket:
    """One folder of a bucket. Every method raises RecordingError in a sentence; none waits for longer than a minute."""

    def __init__(self, address: S3Address) -> None:
        self.address = address
        with needs_extra("s3", "the upload of recordings"):
            import obstore
            from obstore.exceptions import BaseError
            from obstore.store import S3Store
        self._obstore: Any = obstore
        self._errors = BaseError
        endpoint = os.environ.get("AWS_ENDPOINT_URL_S3") or os.environ.get("AWS_ENDPOINT_URL") or ""
        if endpoint and not endpoint.startswith(("http://", "https://")):
            raise RecordingError(f"AWS_ENDPOINT_URL is no address: {endpoint!r}; it looks like https://s3.example.org")
        config: dict[str, Any] = {"aws_checksum_algorithm": "SHA256"}
        if endpoint:
            config["aws_endpoint"] = endpoint
        with self._sentences("use"):
            self._store = S3Store(
                address.bucket,
                prefix=address.prefix or None,
                config=config,  # type: ignore[arg-type]
                client_options={
                    "allow_http": endpoint.startswith("http://"),
                    "connect_timeout": timedelta(seconds=5),
                    "timeout": timedelta(seconds=30),
                },
                retry_config={"max_retries": 1, "retry_timeout": timedelta(seconds=10)},
            )

    def check(self) -> None:
        """Try the rights to list and to write, by an object of a few bytes."""
        with self._sentences("write to"):
            for _ in self._obstore.list(self._store, chunk_size=1):
                break
            self._obstore.put(self._store, CHECK, b"written by movingout to try its rights\n", use_multipart=False)

    def sizes(self) -> dict[str, int]:
        """Bytes of each recording that is there, by name."""
        with self._sentences("list"):
            return {
                str(row["path"]): int(row["size"])
                for batch in self._obstore.list(self._store)
                for row in batch
                if row["path"].endswith(SUFFIX) and "/" not in row["path"]
            }

    def upload(self, path: Path) -> int:
        """Send a recording and make sure that the store has the same bytes; their number."""
        try:
            data = path.read_bytes()
        except OSError as error:
            raise cannot("read", path, error) from error
        digest = hashlib.sha256(data).hexdigest()
        with self._sentences("write to"):
            attributes = {"Content-Type": "application/octet-stream", "sha256": digest}
            self._obstore.put(self._store, path.name, data, attributes=attributes, use_multipart=False)
            if not self._has(path.name, data, digest):
                raise RecordingError(f"{self.address} keeps other bytes of {path.name} than were sent; try again")
        return len(data)

    def delete(self, names: list[str]) -> None:
        """Remove recordings; those that are not there are none to remove."""
        possible = [name for name in names if not misnamed(Path(name))]  # others never got there
        with self._sentences("delete from"):
            if possible:
                self._obstore.delete(self._store, possible)

    def _has(self, name: str, data: bytes, digest: str) -> bool:
        """By size and ETag, the MD5 of the bytes; where the store encrypts it is another, and they are read back."""
        about = self._obstore.head(self._store, name)
        if about["size"] != len(data):
            return False
        tag = str(about["e_tag"] or "").strip('"')
        if _MD5.fullmatch(tag) and tag == hashlib.md5(data, usedforsecurity=False).hexdigest():
            return True
        kept = bytes(self._obstore.get(self._store, name).bytes())
        return hashlib.sha256(kept).hexdigest() == digest

    @contextmanager
    def _sentences(self, what: str) -> Iterator[None]:
        try:
            yield
        except (self._errors, OSError, ValueError) as error:
            raise RecordingError(f"cannot {what} {self.address}: {_reason(error)}") from None


def _reason(error: Exception) -> str:
    """What would help, where the store's answer is known."""
    text = str(error)
    hints = {
        "NoSuchBucket": "there is no such bucket",
        "InvalidAccessKeyId": "the store does not know the key in AWS_ACCESS_KEY_ID",
        "SignatureDoesNotMatch": "AWS_SECRET_ACCESS_KEY does not belong to AWS_ACCESS_KEY_ID",
        "ExpiredToken": "the credentials have expired",
        "AccessDenied": "the credentials have no right to do this",
        "403 Forbidden": "the credentials have no right to do this",
        "Missing AccessKeyId": "AWS_ACCESS_KEY_ID is not set",
        "Missing SecretAccessKey": "AWS_SECRET_ACCESS_KEY is not set",
        "169.254.169.254": "there are no credentials; set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY",
        "dns error": "the name of its endpoint is not known; see AWS_ENDPOINT_URL",
        "onnect": "nothing answers at its endpoint; see AWS_ENDPOINT_URL and AWS_REGION",
        "timed out": "it does not answer in time",
        "NoSuchKey": "it does not have what was just written",
    }
    return next((said for word, said in hints.items() if word in text), text.strip().splitlines()[0][:300])


# ---- a folder and its bucket ---------------------------------------------------------------------------------------


def not_uploaded(folder: Path, address: str) -> list[Path]:
    """The finished recordings of a folder that the bucket does not have in this size, oldest first.

    Copies of deleted recordings are removed: whoever sent one may have been stopped at that moment.
    """
    bucket, deleted = S3Bucket(s3_address(address)), deleted_of(folder.parent)
    there = bucket.sizes()
    bucket.delete(sorted(deleted.intersection(there)))
    paths = (path for path in folder.glob(f"*{SUFFIX}") if path.name not in deleted)
    found = [(path.stat(), path) for path in paths if path.is_file() and not path.is_symlink()]
    missing = [(about.st_mtime_ns, path) for about, path in found if there.get(path.name) != about.st_size]
    return [path for _, path in sorted(missing)]


def note_uploads(data: Path, address: str) -> None:
    """Remember where copies are, so that they can be deleted with their recordings. Raises OSError."""
    known = uploads_of(data)
    if address not in known:
        data.mkdir(parents=True, exist_ok=True)
        with draft_of(data / UPLOADED_TO) as draft:
            draft.write_text("".join(f"{line}\n" for line in [*known, address]), encoding="ascii")


def uploads_of(data: Path) -> list[str]:
    """Addresses that recordings of this data folder were ever sent to. Raises OSError."""
    try:
        return (data / UPLOADED_TO).read_text(encoding="ascii").split()
    except FileNotFoundError:
        return []


def delete_copies(data: Path, names: list[str]) -> None:
    """Delete recordings wherever they were sent to, or are being sent to. Raises RecordingError, OSError."""
    _note_deleted(data, names)  # before: who is just sending one looks here afterwards
    for address in uploads_of(data):
        S3Bucket(s3_address(address)).delete(names)


def deleted_of(data: Path) -> set[str]:
    """The names of all recordings that are to be in no bucket any more. Raises RecordingError."""
    try:
        return set(os.fsdecode((data / DELETED).read_bytes()).split("\n"))
    except FileNotFoundError:
        return set()
    except OSError as error:
        raise cannot("read", data / DELETED, error) from error


def add_notes(other: Path, data: Path) -> None:
    """What another data folder, or a copy of its notes, knows of copies, this one knows as well. Raises OSError."""
    for address in uploads_of(other):
        note_uploads(data, address)
    _note_deleted(data, sorted(deleted_of(other) - deleted_of(data) - {""}))


def _note_deleted(data: Path, names: list[str]) -> None:
    """Append and fsync."""
    if names:
        append_line(data / DELETED, "\n".join(names))


@lru_cache(maxsize=8)
def bucket_at(address: str) -> S3Bucket:
    """One per process, with its connections."""
    return S3Bucket(s3_address(address))


def upload(path: Path, address: str) -> int:
    """Send one recording; the number of bytes, 0 when it has been deleted. Raises RecordingError."""
    bucket, size = bucket_at(address), 0
    if not _is_deleted(path):
        size = bucket.upload(path)
    if _is_deleted(path):  # now, or at an attempt whose own deletion failed
        bucket.delete([path.name])
        return 0
    return size


def _is_deleted(path: Path) -> bool:
    return not path.exists() or path.name in deleted_of(path.parent.parent)
