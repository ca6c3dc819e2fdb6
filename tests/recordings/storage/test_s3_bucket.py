"""Recordings in a bucket: what is sent is there byte for byte, and every refusal is a sentence."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from movingout.recordings import RecordingError
from movingout.recordings.storage.s3_bucket import (
    S3Bucket,
    delete_copies,
    not_uploaded,
    note_uploads,
    s3_address,
    upload,
    uploads_of,
)
from movingout.server.cli import main
from tests.s3_server import S3Server, s3_server


@pytest.fixture
def store(monkeypatch: pytest.MonkeyPatch) -> Iterator[S3Server]:
    with s3_server() as server:
        for name, value in server.environment.items():
            monkeypatch.setenv(name, value)
        yield server


def recording(folder: Path, name: str, content: bytes = b"a recording") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.mcap").write_bytes(content)
    return folder / f"{name}.mcap"


def bucket(address: str = "s3://lab/study") -> S3Bucket:
    return S3Bucket(s3_address(address))


@pytest.mark.parametrize("encrypts", [False, True])
def test_what_is_sent_is_there(store: S3Server, tmp_path: Path, encrypts: bool) -> None:
    store.encrypts = encrypts
    data = bytes(range(256)) * 4000
    assert bucket().upload(recording(tmp_path, "one", data)) == len(data)
    assert store.buckets["lab"] == {"study/one.mcap": data}
    assert bucket().sizes() == {"one.mcap": len(data)}
    assert bucket("s3://lab").sizes() == {}, "of this folder alone"
    bucket().delete(["one.mcap", "never-there.mcap"])
    assert bucket().sizes() == {}


def test_a_name_that_is_not_utf8_never_was_in_a_bucket(store: S3Server, tmp_path: Path) -> None:
    """It kept the data of a participant from being deleted."""
    bucket().upload(recording(tmp_path, "one"))
    bucket().delete(["caf\udce9.mcap", "one.mcap"])
    assert bucket().sizes() == {}


@pytest.mark.parametrize("encrypts", [False, True])
def test_a_store_that_keeps_other_bytes_is_found_out(store: S3Server, tmp_path: Path, encrypts: bool) -> None:
    store.spoils, store.encrypts = True, encrypts
    with pytest.raises(RecordingError, match=r"keeps other bytes of one\.mcap than were sent"):
        bucket().upload(recording(tmp_path, "one"))


def test_what_is_missing_or_of_another_size_is_sent(store: S3Server, tmp_path: Path) -> None:
    store.buckets["lab"] |= {"study/there.mcap": b"a recording", "study/half.mcap": b"a rec"}
    for name in ("there", "half", "new"):
        recording(tmp_path, name)
    (tmp_path / "running.mcap.journal").write_bytes(b"")
    assert {path.name for path in not_uploaded(tmp_path, "s3://lab/study")} == {"half.mcap", "new.mcap"}


def test_one_deleted_while_it_is_sent_does_not_stay(
    store: S3Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = recording(tmp_path, "one")
    sent = S3Bucket.upload

    def send_slowly(self: S3Bucket, path: Path) -> int:
        size = sent(self, path)
        path.unlink()
        return size

    monkeypatch.setattr(S3Bucket, "upload", send_slowly)
    assert upload(path, f"s3://lab/{tmp_path.name}") == 0
    assert store.buckets["lab"] == {}


def test_one_whose_deletion_has_begun_while_it_is_sent_does_not_stay(store: S3Server, tmp_path: Path) -> None:
    """The worst moment: copies are deleted before this one is there, and the file is still there afterwards."""
    path, address = recording(tmp_path / "recordings", "one"), f"s3://lab/{tmp_path.name}"
    note_uploads(tmp_path, address)
    store.on_put = lambda key: delete_copies(tmp_path, ["one.mcap"])
    assert upload(path, address) == 0
    assert path.exists() and store.puts and store.buckets["lab"] == {}


def test_a_copy_left_by_a_killed_sender_is_found_and_deleted(store: S3Server, tmp_path: Path) -> None:
    note_uploads(tmp_path, "s3://lab/study")
    delete_copies(tmp_path, ["gone.mcap", "being deleted.mcap"])
    recording(tmp_path / "recordings", "being deleted")
    store.buckets["lab"] |= {"study/gone.mcap": b"1", "study/moved-away.mcap": b"1"}
    assert not_uploaded(tmp_path / "recordings", "s3://lab/study") == []
    assert store.buckets["lab"] == {"study/moved-away.mcap": b"1"}


def test_a_deletion_that_the_store_refused_is_tried_again(store: S3Server, tmp_path: Path) -> None:
    path, address = recording(tmp_path / "recordings", "one"), f"s3://lab/{tmp_path.name}"
    note_uploads(tmp_path, address)

    def refuse_from_now_on(key: str) -> None:
        path.unlink()
        store.fails = "AccessDenied"

    store.on_put = refuse_from_now_on
    with pytest.raises(RecordingError):
        upload(path, address)
    assert list(store.buckets["lab"]) == [f"{tmp_path.name}/one.mcap"]
    store.fails = ""
    assert upload(path, address) == 0 and store.buckets["lab"] == {}


def test_copies_are_deleted_wherever_they_were_sent(store: S3Server, tmp_path: Path) -> None:
    for address in ("s3://lab/a", "s3://lab/b", "s3://lab/a"):
        note_uploads(tmp_path, address)
    assert uploads_of(tmp_path) == ["s3://lab/a", "s3://lab/b"]
    store.buckets["lab"] |= {"a/gone.mcap": b"1", "b/gone.mcap": b"1", "b/stays.mcap": b"1"}
    delete_copies(tmp_path, ["gone.mcap"])
    assert store.buckets["lab"] == {"b/stays.mcap": b"1"}


@pytest.mark.parametrize(
    ("variables", "address", "sentence"),
    [
        ({}, "s3://nowhere", "cannot write to s3://nowhere: there is no such bucket"),
        ({"AWS_ACCESS_KEY_ID": "wrong"}, "s3://lab", "the store does not know the key in AWS_ACCESS_KEY_ID"),
        ({"AWS_ENDPOINT_URL": "http://127.0.0.1:1"}, "s3://lab", "nothing answers at its endpoint"),
        ({"AWS_ENDPOINT_URL": "nonsense"}, "s3://lab", "AWS_ENDPOINT_URL is no address: 'nonsense'"),
        ({}, "s3:lab", "'s3:lab' is no address of a bucket; it looks like s3://bucket/folder"),
        ({}, "s3://lab/../x", "is no address of a bucket"),
    ],
)
def test_a_wrong_bucket_key_or_endpoint_is_one_sentence_at_the_start(
    store: S3Server,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    variables: dict[str, str],
    address: str,
    sentence: str,
) -> None:
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert main(["play", "--port", "0", "--data", str(tmp_path / "data"), "--s3", address]) == 2
    said = capsys.readouterr().err.strip()
    assert sentence in said and len(said.splitlines()) == 1
    assert store.buckets["lab"] == {} and uploads_of(tmp_path / "data") == []


def test_without_rights_and_without_a_key_it_says_so(store: S3Server, monkeypatch: pytest.MonkeyPatch) -> None:
    store.fails = "AccessDenied"
    with pytest.raises(RecordingError, match="the credentials have no right to do this"):
        bucket().check()
    monkeypatch.delenv("AWS_ACCESS_KEY_ID")
    with pytest.raises(RecordingError, match="AWS_ACCESS_KEY_ID is not set"):
        bucket()


def test_the_command_sends_what_is_missing(store: S3Server, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("one", "two"):
        recording(tmp_path / "recordings", name)
    command = ["recordings", "upload", "s3://lab/all/", "--data", str(tmp_path), "--json"]
    assert main(command) == 0
    assert json.loads(capsys.readouterr().out) == {"sent": 2, "bytes": 22, "problems": []}
    assert main(command) == 0
    assert json.loads(capsys.readouterr().out)["sent"] == 0
    assert {name for name in store.buckets["lab"] if name.endswith(".mcap")} == {"all/one.mcap", "all/two.mcap"}
    assert uploads_of(tmp_path) == ["s3://lab/all"]
