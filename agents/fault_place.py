"""Where an agent's own code raised an exception: file and line, for the one sentence that its author reads."""

import sysconfig
from pathlib import Path
from types import TracebackType

_PRODUCT = Path(__file__).absolute().parents[1]
_PATHS = sysconfig.get_paths()
_STANDARD = tuple(Path(_PATHS[name]).resolve() for name in ("stdlib", "platstdlib"))
_INSTALLED = tuple(Path(_PATHS[name]).resolve() for name in ("purelib", "platlib"))


LONGEST_SENTENCE = 500


def located(sentence: str, error: BaseException) -> str:
    """The sentence about an exception, with the place in brackets behind it; long ones lose the end of their words.

    It is one line, whatever the exception says: of several lines, of nothing, of a file whose name is not UTF-8.
    """
    sentence = writable(" ".join(sentence.removesuffix(": ").split()))
    place = writable(fault_place(error))
    behind = f" ({place})" if place else ""
    return sentence[: LONGEST_SENTENCE - len(behind)] + behind


def writable(text: str) -> str:
    """The text as UTF-8 can have it: the half of a surrogate pair, which messages and files refuse, as `\\udce9`."""
    return text.encode("utf-8", "backslashreplace").decode()


def fault_place(error: BaseException) -> str:
    """`my_policy.py, line 12`: the innermost line of somebody's own code that the exception came through.

    A library that this code called is passed over, unless the agent itself is an installed library. Empty when there is
    no such line: the exception came from this package, or from a call with the wrong arguments.
    """
    if isinstance(error, SyntaxError) and error.filename and error.lineno:
        return _words(Path(error.filename), error.lineno)
    foreign = [(path, line) for path, line in _lines(error.__traceback__) if not _belongs(path)]
    own = [(path, line) for path, line in foreign if not _is_in(path, _INSTALLED)]
    if own:
        return _words(*own[-1])
    return _words(*foreign[0]) if foreign else ""


def _lines(traceback: TracebackType | None) -> list[tuple[Path, int]]:
    """File and line of each frame, outermost first."""
    found: list[tuple[Path, int]] = []
    while traceback is not None:
        found.append((Path(traceback.tb_frame.f_code.co_filename), traceback.tb_lineno))
        traceback = traceback.tb_next
    return found


def _belongs(path: Path) -> bool:
    """Whether a file is of this package, of Python itself, or no file at all (`<frozen importlib._bootstrap>`).

    Compiled libraries name the source that they were made from (`numpy/random/_common.pyx`), which is not here.
    """
    if (
        str(path).startswith("<")
        or path.suffix in (".pyx", ".pxd", ".pxi")
        or path.is_relative_to(_PRODUCT)
        or _is_in(path, (_PRODUCT.resolve(),))
    ):
        return True
    return _is_in(path, _STANDARD) and not _is_in(path, _INSTALLED)


def _is_in(path: Path, folders: tuple[Path, ...]) -> bool:
    return any(path.resolve().is_relative_to(folder) for folder in folders)


def _words(path: Path, line: int) -> str:
    """The path as seen from the current folder, else its last two parts: recordings hold no paths of a machine."""
    here = Path.cwd()
    shown = path.relative_to(here) if path.is_relative_to(here) else Path(*path.absolute().parts[-2:])
    return f"{shown}, line {line}"
