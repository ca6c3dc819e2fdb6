"""The recordings a viewer was started with, read when they are wanted."""

from collections import OrderedDict
from collections.abc import Sequence
from pathlib import Path

from movingout.recordings.episode import Episode
from movingout.recordings.file_format.reader import read_episode

_KEPT = 8  # episodes in memory


class RecordingCache:
    """Named recordings. Reading one may raise RecordingError."""

    def __init__(self, paths: Sequence[Path]) -> None:
        names = [path.name.split(".")[0] for path in paths]
        unique = len(set(names)) == len(names)
        self._paths = {name if unique else str(path): path for name, path in zip(names, paths, strict=True)}
        self._read: OrderedDict[str, Episode] = OrderedDict()

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self._paths)

    @property
    def shown_first(self) -> tuple[str, ...]:
        """Two recordings stand side by side from the start; of more, the first."""
        return self.names if len(self.names) <= 2 else self.names[:1]

    def episode(self, name: str) -> Episode:
        if name not in self._read:
            self._read[name] = read_episode(self._paths[name])
            while len(self._read) > _KEPT:
                self._read.popitem(last=False)
        return self._read[name]
