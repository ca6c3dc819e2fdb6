"""The grids that come with the project, by name."""

from pathlib import Path

from movingout.maps.suggestion import known_names
from movingout.matches.errors import MatchError

FOLDER = Path(__file__).resolve().parents[1] / "protocols"


def shipped_grids() -> list[str]:
    """The names, sorted."""
    return sorted(path.stem for path in FOLDER.glob("*.yaml"))


def grid_path(grid: Path) -> Path:
    """The file of a shipped grid where `grid` is its name, else `grid` itself.

    A folder of that name, as that of its results, is no grid. Raises MatchError for a bare word that is neither a file
    nor the name of a grid.
    """
    if grid.name != str(grid) or (grid.exists() and not grid.is_dir()):
        return grid
    if grid.stem in shipped_grids():
        return FOLDER / f"{grid.stem}.yaml"
    if not grid.suffix:
        raise MatchError(f"there is no grid {str(grid)!r}; {known_names(str(grid), shipped_grids())}, or a YAML file")
    return grid
