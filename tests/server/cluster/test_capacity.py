"""How many nodes a number of participants needs."""

import json
import re
from pathlib import Path

import pytest

from movingout.server.cli import main
from movingout.server.cluster.capacity import FIGURES, MOST_NODES, Plan, plan, read_figures
from movingout.server.cluster.errors import ClusterError


def planned(participants: int, agent: str = "") -> Plan:
    return plan(participants, agent, read_figures(FIGURES))


def test_every_figure_says_where_it_comes_from() -> None:
    figures = read_figures(FIGURES)
    assert all(len(getattr(figures, name).source) > 20 for name in figures.__struct_fields__)


def test_pairs_need_half_as_many_rooms_and_no_agents() -> None:
    small = planned(2)
    assert (small.rooms, small.nodes, small.cores) == (1, 1, 1)
    pairs, partners = planned(1000), planned(1000, "bass@any")
    assert (pairs.rooms, partners.rooms) == (500, 1000)
    assert pairs.cores == pairs.nodes == 8  # 69 rooms take half of a core
    assert partners.nodes == 15 and partners.cores == 15 + 101  # 1,005 agents (67 a node) at 8 %, 80 % of a core each
    assert partners.recorded_gb_per_hour == pytest.approx(2 * pairs.recorded_gb_per_hour, rel=0.01)


def test_agents_need_memory_too() -> None:
    figures = read_figures(FIGURES)
    found = planned(1000, "bass@any")
    workers = found.nodes * found.workers_per_node
    agents_mb = workers * figures.agent_worker_mb.value + 1000 * figures.agent_mb.value
    rooms_mb = found.nodes * figures.node_mb.value + 1000 * figures.room_mb.value
    assert found.memory_gb == pytest.approx((rooms_mb + agents_mb) / 1e3, abs=0.06) and agents_mb > rooms_mb


@pytest.mark.parametrize("agent", ["scripted", "dp@any", "bass@any"])
def test_the_agents_that_play_anywhere_were_measured(agent: str) -> None:
    assert not any("not measured" in note for note in planned(60, agent).notes)


def test_idle_partners_cost_nothing_and_unknown_ones_are_said_to_be_unmeasured() -> None:
    assert planned(60, "idle").cores == 1
    assert any("not measured" in note for note in planned(60, "my.policy:Agent").notes)


def test_more_nodes_than_a_cluster_has_are_several_clusters() -> None:
    huge = planned(100_000, "bass@any")
    assert huge.nodes > MOST_NODES and any("clusters" in note for note in huge.notes)


def test_the_command_prints_a_table_or_json(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["cluster", "plan", "--participants", "1000", "--agent", "bass@any", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["nodes"] == 15
    assert main(["cluster", "plan", "--participants", "40", "--core-hour-price", "0.05"]) == 0
    out = capsys.readouterr().out
    assert "nodes" in out and "cost per hour" in out and "2026-11-21" in out
    file = tmp_path / "figures.yaml"
    file.write_text("core_per_room: {value: many, unit: x, source: y}")
    assert main(["cluster", "plan", "--participants", "2", "--figures", str(file)]) == 2
    assert "has no figures for a plan" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ("--participants 0", "--participants: a whole number from 1 to 1,000,000 is possible, not 0"),
        ("--participants -5", "a whole number from 1 to 1,000,000 is possible, not -5"),
        ("--participants 99999999999999999999999999", "a whole number from 1 to 1,000,000 is possible"),
        ("--participants 9 --core-hour-price -1", "--core-hour-price: a price from 0 to 1,000,000 is possible, not -1"),
        ("--participants 9 --core-hour-price nan", "a price from 0 to 1,000,000 is possible, not nan"),
        ("--participants 9 --core-hour-price 1e400", "a price from 0 to 1,000,000 is possible, not 1e400"),
        ("--participants 9 --core-hour-price cheap", "a price from 0 to 1,000,000 is possible, not cheap"),
    ],
)
def test_numbers_that_no_plan_can_be_made_with_are_refused(
    capsys: pytest.CaptureFixture[str], words: str, why: str
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["cluster", "plan", *words.split()])
    assert ended.value.code == 2 and why in capsys.readouterr().err
    for participants in (0, 1_000_001):
        with pytest.raises(ClusterError, match="a plan is for 1 to 1,000,000 participants"):
            planned(participants)


@pytest.mark.parametrize("value", ["0", "-1", ".nan", ".inf", "0.6"])
def test_figures_that_nothing_can_be_reckoned_with_are_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, value: str
) -> None:
    """A room that takes 0.6 of a core finds none: rooms may take half of one."""
    file = tmp_path / "figures.yaml"
    file.write_text(FIGURES.read_text().replace("value: 0.0072", f"value: {value}"))
    assert main(["cluster", "plan", "--participants", "2", "--figures", str(file)]) == 2
    assert re.search("core has no room|has no figures for a plan: .*core_per_room", capsys.readouterr().err)


def test_a_file_that_is_not_there_is_said() -> None:
    with pytest.raises(ClusterError, match="no figures for a plan"):
        read_figures(Path("/nowhere"))
