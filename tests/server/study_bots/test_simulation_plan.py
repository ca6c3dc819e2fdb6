"""The options of `movingout study simulate` are the fields of the plan."""

import pytest

from movingout.maps.commands.parser import CommandParser
from movingout.server.options import values_of
from movingout.server.study_bots.commands import simulate
from movingout.server.study_bots.simulation_plan import MAX_SPEED, SimulationPlan


def plan_of(*options: str) -> SimulationPlan:
    parser = CommandParser()
    simulate.configure(parser.add_subparsers())
    args = parser.parse_args(["simulate", "study.yaml", "--participants", "4", *options])
    return SimulationPlan(**values_of(args, SimulationPlan))


def test_without_options_the_defaults_of_the_plan_hold() -> None:
    assert plan_of() == SimulationPlan(4)


def test_every_option_sets_its_field() -> None:
    plan = plan_of("--speed", "max", "--seed", "3", "--at-once", "2", "--chaos", "--slow-agents")
    assert plan == SimulationPlan(4, speed=MAX_SPEED, seed=3, at_once=2, chaos=True, slow_agents=True)


@pytest.mark.parametrize("speed", ["0", "21", "fast"])
def test_an_impossible_speed_is_refused(speed: str) -> None:
    with pytest.raises(SystemExit):
        plan_of("--speed", speed)
