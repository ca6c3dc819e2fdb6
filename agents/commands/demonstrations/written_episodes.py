"""What `movingout demos` wrote into a folder, as it is told of on the screen and in its JSON document."""

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from rich.console import Console
from rich.progress import Progress

from movingout.agents.data.dagger import LabellingJob
from movingout.agents.data.demonstrations import EpisodeJob, WrittenEpisode, of_other_code
from movingout.maps.generated.names import is_generated
from movingout.maps.suggestion import counted
from movingout.maps.symmetry import SEPARATOR, split_name


class WrittenEpisodes(NamedTuple):
    """Those that were made, which alone have rates here; of `wanted`, the others were there already."""

    out: Path
    made: list[WrittenEpisode]
    wanted: int

    def counts(self) -> dict[str, object]:
        """How many episodes were made, and how many were there already."""
        return {"out": str(self.out), "episodes": len(self.made), "already": self.wanted - len(self.made)}

    def mean_tcr(self) -> float | None:
        """The mean task completion rate, 0 to 1; None where nothing was made."""
        return sum(one.tcr for one in self.made) / len(self.made) if self.made else None

    def tcr_per_map(self) -> dict[str, float]:
        """The mean task completion rate, 0 to 1, by the name of the map."""
        names = sorted({one.map for one in self.made})
        rates = {name: [one.tcr for one in self.made if one.map == name] for name in names}
        return {name: round(sum(values) / len(values), 3) for name, values in rates.items()}

    def summary(self) -> str:
        """`wrote 2 episodes to data/demos, mean TCR 0.50; 1 were there already`"""
        before = self.wanted - len(self.made)
        kept = f"; {before} were there already" if before else ""
        mean = self.mean_tcr()
        if mean is None:
            return f"nothing new in {self.out}{kept}"
        return f"wrote {counted(len(self.made), 'episode')} to {self.out}, mean TCR {mean:.2f}{kept}"

    def group_lines(self) -> Iterator[str]:
        """A line for each map with its symmetries, and for the generated maps of each mode."""
        groups: dict[str, list[WrittenEpisode]] = {}
        for one in sorted(self.made, key=lambda episode: episode.map):
            groups.setdefault(_group_of(one.map), []).append(one)
        for name, episodes in groups.items():
            rate = sum(one.tcr for one in episodes) / len(episodes)
            maps = len({one.map for one in episodes})
            counts = f"{counted(len(episodes), 'episode')}{f' on {maps} maps' if maps > 1 else ''}"
            yield f"  {name:21}  TCR {rate:.2f}  {counts}"


def _group_of(map_name: str) -> str:
    """The map without its symmetries; of a generated one `generated:MODE`."""
    if is_generated(map_name):
        return SEPARATOR.join(map_name.split(SEPARATOR)[:2])
    return split_name(map_name)[0]


def with_progress(total: int, episodes: Iterator[WrittenEpisode]) -> list[WrittenEpisode]:
    """All of them, with a bar that goes on with each."""
    made: list[WrittenEpisode] = []
    with Progress(console=Console(stderr=True)) as progress:
        bar = progress.add_task("episodes", total=total)
        for one in episodes:
            made.append(one)
            progress.advance(bar)
    return made


def other_code_told(todo: Sequence[EpisodeJob | LabellingJob], out: Path) -> int:
    """How many episodes of other code of ours are kept, which is said."""
    if other := of_other_code(todo, out):
        what = f"{counted(other, 'episode')} in {out} {'were' if other != 1 else 'was'}"
        print(
            f"movingout: {what} made with other code of this project; to make all with the present code, use an empty "
            "folder",
            file=sys.stderr,
        )
    return other
