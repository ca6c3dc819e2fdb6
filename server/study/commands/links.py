"""`movingout study links`: links that only the experimenter can make, one per participant."""

import argparse
import json
import time
from pathlib import Path
from urllib.parse import urlsplit

from movingout.maps.commands.parser import folder
from movingout.server.settings import DATA
from movingout.server.study.arrivals.signed_links import LinkSigner
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.study_file import read_study
from movingout.study.errors import StudyError

MOST_LINKS = 100_000
MOST_DAYS = 3660.0
PAGE = "/study"  # of participants


def configure(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser(
        "links",
        help="signed links for participants, one each, valid for some days",
        example="movingout study links study.yaml --address https://study.example.org --ids P01 P02",
    )
    add = parser.add_argument
    add("file", type=Path, metavar="FILE", help="the study file")
    add("--address", required=True, metavar="URL", help="address of the server, as participants reach it")
    add("--ids", nargs="+", default=[], metavar="ID", help="ids of the participants: letters, digits, dots and dashes")
    add("--number", type=int, default=0, metavar="N", help="make so many links with ids P0001, P0002, ...")
    add("--first", type=int, default=1, metavar="N", help="number to begin with, for more links later (%(default)s)")
    add("--days", type=float, default=14.0, metavar="D", help="begin within so many days (%(default)s)")
    add("--data", type=folder, default=DATA, metavar="DIR", help="the data folder (%(default)s), which has the key")
    add("--json", action="store_true", help="one JSON document on standard output")
    parser.set_defaults(perform=run)


def run(args: argparse.Namespace) -> int:
    """Print "id<tab>link" lines, or a document whose `until` are seconds since the epoch. Raises MovingOutError."""
    study = read_study(args.file)
    page = _page_at(args.address)
    if not 0 <= args.number <= MOST_LINKS or not 0.0 < args.days <= MOST_DAYS:
        raise StudyError(f"--number is from 1 to {MOST_LINKS}, and --days more than 0 and at most {MOST_DAYS:g}")
    if args.first < 1:
        raise StudyError(f"--first is at least 1, not {args.first}")
    ids = [*args.ids, *(f"P{number:04}" for number in range(args.first, args.first + args.number))]
    if not ids:
        raise StudyError("name the participants with --ids, or say how many there are with --number")
    signer = LinkSigner.in_folder(StudyFolder(study, args.data).own, study.id)
    until = int(time.time() + args.days * 86_400)
    urls = {id: f"{page}?{signer.query(id, until)}" for id in ids}
    if args.json:
        links = [{"id": id, "url": url, "until": until} for id, url in urls.items()]
        print(json.dumps({"study": study.id, "links": links}, indent=2))
    else:
        print("\n".join(f"{id}\t{url}" for id, url in urls.items()))
    return 0


def _page_at(address: str) -> str:
    """The page of the study at a server, which may be named by that page; a server does not lie under a path."""
    parts = urlsplit(address)
    if parts.scheme not in ("http", "https") or not parts.netloc or parts.path.rstrip("/") not in ("", PAGE):
        raise StudyError(f"--address is like https://study.example.org, not {address!r}")
    return f"{parts.scheme}://{parts.netloc}{PAGE}"
