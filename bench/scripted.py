"""What two scripted agents deliver within 500 ticks on each map, and what one delivers beside an idle partner."""

from bench import print_table
from movingout.maps import map_names
from movingout.matches import Match, MatchResult, play_matches
from movingout.world.constants import LIMIT_TICKS

TICKS = LIMIT_TICKS


def main() -> None:
    """Play both and print one table; about a minute."""
    names = map_names()
    pairs = {result.match.map: result for result in played("scripted", names)}
    alone = {result.match.map: result for result in played("idle", names)}
    rows = [[name, *_pair(pairs[name]), f"{alone[name].delivered}/{alone[name].items}"] for name in names]
    print_table(
        f"scripted + scripted, {TICKS} ticks, seed 0; last column: with an idle partner",
        ["map", "delivered", "ticks", "CPU ms/tick", "alone"],
        rows,
    )
    complete = sum(result.ending == "delivered" for result in pairs.values())
    print(f"everything delivered on {complete} of {len(names)} maps (goal: all)")


def played(partner: str, names: tuple[str, ...]) -> list[MatchResult]:
    """One match per map, a scripted agent in blue beside `partner`."""
    return list(play_matches([Match(name, "scripted", partner, 0, ticks=TICKS) for name in names]))


def _pair(result: MatchResult) -> list[str]:
    return [f"{result.delivered}/{result.items}", str(result.ticks), f"{result.cpu_s * 1e3 / result.ticks:.1f}"]
