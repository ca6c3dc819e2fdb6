"""The protocols that come with the project: grids by name."""

from pathlib import Path

FOLDER = Path(__file__).resolve().parents[1] / "protocols"


def protocol_names() -> list[str]:
    return sorted(path.stem for path in FOLDER.glob("*.yaml"))


def protocol_path(grid: Path) -> Path:
    """The file of a shipped protocol when `grid` is its name, else `grid` itself."""
    if not grid.exists() and grid.name == str(grid) and grid.stem in protocol_names():
        return FOLDER / f"{grid.stem}.yaml"
    return grid
