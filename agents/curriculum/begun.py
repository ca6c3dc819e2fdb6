"""With which sizes a folder of `make anywhere` was begun: a file beside what was made.

What has been done is not done again, and most of it does not say with what it was done. So other sizes in the same
folder would train nothing new, or mix what does not belong together. Of a list of partners, whom it names is kept, too.
"""

import hashlib
import json
from dataclasses import asdict
from pathlib import Path

from movingout.agents.curriculum.recipe_anywhere import AnywhereSizes
from movingout.agents.errors import DataError
from movingout.agents.partners.families import group, is_group

FREE = (
    "data",
    "workers",
    "ray",
    "seeds",
    "response_rounds",
)  # of these, others only add agents, or make nothing different
_WHO = "partners_sha256"  # folders of before have none


def check_begun(sizes: AnywhereSizes) -> None:
    """Raises DataError when the data folder was begun with other sizes, or when its file cannot be read."""
    path, mine = _path(sizes), _kept(sizes)
    try:
        begun = json.loads(path.read_text(encoding="utf-8"))
        others = [name for name in mine if name in begun and begun[name] != mine[name]]
    except FileNotFoundError:
        return
    except (OSError, ValueError, TypeError) as error:
        raise DataError(
            f"cannot read {path}, which says with what it was begun: {error}; choose another --data"
        ) from error
    if others == [_WHO]:
        raise DataError(f"{sizes.partners} has changed since {path.parent} was begun with it; choose another --data")
    others = [name for name in others if name != _WHO]
    if others:
        before, now = (" ".join(_option(name, values[name]) for name in others) for values in (begun, mine))
        raise DataError(f"{path.parent} was begun with {before}, not {now}; choose another --data")


def note_begun(sizes: AnywhereSizes) -> None:
    """Write the sizes into a data folder that is begun now."""
    path = _path(sizes)
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(_kept(sizes), indent=1) + "\n", encoding="utf-8")


def _path(sizes: AnywhereSizes) -> Path:
    return sizes.data / "anywhere" / "sizes.json"


def _kept(sizes: AnywhereSizes) -> dict[str, object]:
    kept = {name: value for name, value in asdict(sizes).items() if name not in FREE}
    if is_group(sizes.partners):  # whose members may change: lists, packages, and families with new versions
        ids = "\n".join(one.agent_id for one in group(sizes.partners))
        kept[_WHO] = hashlib.sha256(ids.encode()).hexdigest()
    return kept


def _option(name: str, value: object) -> str:
    """As it is written on the command line."""
    words = f"--{name.replace('_', '-')}"
    if isinstance(value, bool):
        return words if value else f"no {words}"
    return f"{words} {value}"
