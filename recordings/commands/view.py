"""`movingout recordings view`: recordings in 3D, live or as one offline page."""

import argparse
import contextlib
from pathlib import Path

from movingout.maps.extras import needs_extra
from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format.reader import read_episode
from movingout.recordings.html_page import check_name, write_html
from movingout.recordings.storage.index import path_of

PORT = 8080
MOST_ON_A_PAGE = 2


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("recordings", nargs="+", metavar="FILE", help="files, or episode ids in DATA/recordings")
    parser.add_argument(
        "--html", type=Path, metavar="OUT", help="write one offline page of one or two episodes instead"
    )
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on (default: this machine only)")
    parser.add_argument("--port", type=int, default=PORT, help=f"default: {PORT}; 0 takes a free one")
    parser.add_argument("--data", type=Path, default=Path("data"), metavar="DIR", help="default: ./data")
    parser.set_defaults(perform=view)


def view(args: argparse.Namespace) -> int:
    """Raises RecordingError."""
    paths = [_path(name, args.data) for name in args.recordings]
    return _page(paths, args.html) if args.html else _serve(paths, args.host, args.port)


def _path(name: str, data: Path) -> Path:
    path = Path(name)
    return path if path.exists() or path.suffix else path_of(data / "recordings", name)


def _page(paths: list[Path], out: Path) -> int:
    with needs_extra("view", "the 3D viewer"):
        from movingout.recordings.viewer.offline import page  # viser takes most of a second to import

    check_name(out)
    if len(paths) > MOST_ON_A_PAGE:
        raise RecordingError(
            f"a page shows one or two episodes, not {len(paths)}; without --html the viewer takes more"
        )
    write_html(page([read_episode(path) for path in paths]), out)
    print(f"wrote {out} ({out.stat().st_size / 1e6:.1f} MB); it opens by double click, without the network")
    return 0


def _serve(paths: list[Path], host: str, port: int) -> int:
    with needs_extra("view", "the 3D viewer"):
        from movingout.recordings.viewer.recording_cache import RecordingCache
        from movingout.recordings.viewer.viewer import Viewer

    with Viewer(RecordingCache(paths), host, port) as viewer:
        print(f"viewer on {viewer.url}  (Ctrl-C ends it)", flush=True)
        if host not in ("127.0.0.1", "localhost", "::1"):
            print("everybody who reaches this address sees these recordings: there is no password", flush=True)
        with contextlib.suppress(KeyboardInterrupt):
            viewer.run()
    return 0
