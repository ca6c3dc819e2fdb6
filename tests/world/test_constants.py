"""The clock is stated once, in world/constants.py; everything else derives from it."""

import ast
from collections.abc import Iterator
from pathlib import Path

import movingout.world.constants as c
from movingout.maps import load_map
from movingout.world import World
from movingout.world.physics import _SAMPLED_HALVES

ROOT = Path(__file__).parents[2]
PACKAGES = ("agents", "bench", "maps", "matches", "recordings", "server", "study", "world")
CLOCK_NUMBERS = {"tick": (0.1, 0.05, 100), "pose": (0.02, 20), "poses": (5,), "ticks": (500, 36_000)}


def test_the_sub_step_is_the_official_one_to_the_bit() -> None:
    assert c.SUB_STEP_SECONDS.hex() == ((1 / 20) / 10).hex()
    assert (c.TICKS_PER_SECOND, c.TICK_MS, c.POSE_SECONDS, c.MAX_TICKS) == (10, 100, 0.02, 36_000)


def test_a_tick_is_two_halves_cut_where_a_pose_is_due() -> None:
    assert World(load_map("Simple"), record_sub_poses=False)._halves == ((10,), (10,))
    assert _SAMPLED_HALVES == ((4, 4, 2), (2, 4, 4))


def test_no_other_module_states_the_clock_again() -> None:
    paths = [path for package in PACKAGES for path in (ROOT / package).rglob("*.py")]
    found = [f"{path.relative_to(ROOT)}: {name}" for path in paths for name in _restated(path)]
    assert [place for place in found if not place.startswith("world/constants.py")] == []


def _restated(path: Path) -> Iterator[str]:
    """Constants and fields of a module that name the clock and hold one of its numbers."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Assign | ast.AnnAssign) and isinstance(node.value, ast.Constant):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names = [target.id for target in targets if isinstance(target, ast.Name)]
            yield from (name for name in names if _is_clock(name, node.value.value))


def _is_clock(name: str, value: object) -> bool:
    return any(value in CLOCK_NUMBERS.get(word, ()) for word in name.lower().split("_"))
