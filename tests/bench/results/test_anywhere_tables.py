"""What the tables of agents anywhere say: means over maps, differences over the same episodes, and shares."""

from bench.results.anywhere_tables import Played, differences, idle_was_better, interdependence, table, tables
from bench.results.episode_log import Outcome, Run


def outcome(agent: str, the_map: str, seed: int, tcr: float, together: float | None = None) -> Outcome:
    return Outcome(Run(agent, "p", the_map, 0, seed, 500), tcr, tcr / 2, 1.0, None, 0.0, together)


def played(**by_agent: list[float]) -> Played:
    """Two episodes on one map, then one on another."""
    maps = ("m", "m", "n")
    return {
        agent: {"12 maps": [outcome(agent, maps[k], k, tcr) for k, tcr in enumerate(rates)]}
        for agent, rates in by_agent.items()
    }


BOTH = played(mine=[1.0, 0.5, 0.25], other=[0.5, 0.5, 0.5], idle=[0.5, 0.75, 0.25])


def test_a_cell_has_the_mean_over_maps_its_error_and_the_difference_to_the_idle_partner() -> None:
    assert table(BOTH).splitlines() == [
        "| TCR | 12 maps | n per cell |",
        "|---|---|---|",
        "| mine | 0.500 ± 0.250 (+0.062 ± 0.062) | 3 |",  # maps: 0.75 and 0.25; minus idle: 0.125 and 0
        "| other | 0.500 ± 0.000 (+0.062 ± 0.188) | 3 |",
        "| idle | 0.438 ± 0.188 | 3 |",
    ]
    assert table(BOTH, "nfd").splitlines()[2] == "| mine | 0.250 ± 0.125 (+0.031 ± 0.031) | 3 |"


def test_the_first_two_agents_are_compared_over_the_same_episodes() -> None:
    assert differences(BOTH, "mine", "other").splitlines()[2:] == [
        "| TCR, mine minus other | +0.000 ± 0.250 | 3 |",
        "| NFD, mine minus other | +0.000 ± 0.125 | 3 |",
    ]


def test_how_often_the_idle_partner_was_the_better_one() -> None:
    assert idle_was_better(BOTH).splitlines()[2:] == ["| mine | 33% | 3 |", "| other | 33% | 3 |"]


def test_interdependence_is_that_of_the_episodes_in_which_something_was_delivered() -> None:
    cells = [outcome("mine", "m", 0, 1.0, 1.0), outcome("mine", "m", 1, 1.0), outcome("mine", "n", 2, 1.0, 0.5)]
    assert interdependence({"mine": {"12 maps": cells}}).splitlines()[2] == "| mine | 0.750 ± 0.250 | 3 |"
    assert interdependence(BOTH).splitlines()[2] == "| mine | – | 3 |", "logs of earlier versions do not tell"


def test_a_difference_on_one_map_has_no_error() -> None:
    one_map: Played = {agent: {"m": cells["12 maps"][:2]} for agent, cells in BOTH.items()}
    assert table(one_map).splitlines()[2] == "| mine | 0.750 (+0.125) | 2 |"


def test_an_agent_alone_is_compared_with_nobody() -> None:
    text = tables(played(mine=[1.0, 1.0, 1.0]))
    assert "minus" not in text and "idle was better" not in text
    assert tables(BOTH).count("| n per cell |") == 5
