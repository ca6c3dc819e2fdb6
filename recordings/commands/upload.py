"""`movingout recordings upload`: recordings that a bucket does not have yet are sent there."""

import argparse

from movingout.maps.commands.parser import add_json
from movingout.maps.commands.sentences import tell
from movingout.maps.files.terminal import printable
from movingout.maps.suggestion import counted
from movingout.recordings.commands.arguments import add_data, print_json
from movingout.recordings.errors import RecordingError
from movingout.recordings.progress import with_progress
from movingout.recordings.storage.s3_bucket import S3Bucket, not_uploaded, note_uploads, s3_address, upload


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("address", metavar="URL", help="s3://BUCKET/FOLDER")
    add_data(parser)
    add_json(parser)
    parser.set_defaults(perform=run)


def run(args: argparse.Namespace) -> int:
    """Exit code 1 when some could not be sent. Raises RecordingError."""
    address = str(s3_address(args.address))
    S3Bucket(s3_address(address)).check()
    try:
        note_uploads(args.data, address)
    except OSError as error:
        raise RecordingError(f"cannot write to {args.data}: {error.strerror or error}") from None
    missing, sent, size, problems = not_uploaded(args.data / "recordings", address), 0, 0, []
    for path in with_progress(missing, len(missing), "sending"):
        try:
            size += (count := upload(path, address))
            sent += count > 0
        except RecordingError as error:
            problems.append(f"{path.name}: {error}")
    if args.json:
        print_json({"sent": sent, "bytes": size, "problems": problems})
    else:
        print(f"sent {counted(sent, 'recording')}, {size / 1e6:.1f} MB, to {address}")
        for problem in problems:
            tell(printable(problem))
    return 1 if problems else 0
