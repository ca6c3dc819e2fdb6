"""The training `response`: a policy that is steered by reinforcement learning to answer many partners, on its leash.

What it makes is a checkpoint of the policy's own kind, which is loaded and plays like any other.
"""

import argparse
import datetime
import hashlib
import json
from typing import TYPE_CHECKING

from movingout.agents.checkpoint.card import MAX_LINE
from movingout.agents.checkpoint.checkpoint import Checkpoint
from movingout.agents.data.rollout import check_undelivered
from movingout.agents.errors import DataError
from movingout.agents.kinds.kind import AgentKind, Trained
from movingout.agents.kinds.policy import check_policy, load_policy, weighted_policy
from movingout.agents.partners.families import group, test_people_caution, to_try
from movingout.agents.reinforcement.config import ResponseConfig
from movingout.agents.training.learned_data import on_maps
from movingout.agents.training.run import RoundsMade, TrainingRun
from movingout.maps import load_map, map_to_json
from movingout.maps.randomize import pairs_on
from movingout.maps.selection import HELP, selected_maps
from movingout.maps.suggestion import counted, shortened
from movingout.world.constants import LIMIT_TICKS
from movingout.world.observation import LAYOUTS

if TYPE_CHECKING:
    from movingout.agents.policies.diffusion_policy import DiffusionPolicy
    from movingout.agents.reinforcement.rooms import EpisodeDistribution


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--base", required=True, help="id of the imitated policy that is steered")
    parser.add_argument("--map", default="generated:training", help=f"what is played (default %(default)s): {HELP}")
    parser.add_argument(
        "--partners",
        nargs="+",
        default=["families"],
        help="whom it plays with, each as often: ids, people:A, families, @FILE, … (default: families)",
    )
    parser.add_argument("--ticks", type=int, default=LIMIT_TICKS, help="limit of an episode (%(default)s)")


def _train(run: TrainingRun[ResponseConfig]) -> Trained:
    """Play and learn in turns, then export the policy with its steering inside."""
    from movingout.agents.policies.export import save_policy
    from movingout.agents.reinforcement.best_response import BestResponse, learn_response
    from movingout.agents.reinforcement.steered_policy import SteeredPolicy

    options, config = run.options, run.config
    base = run.find(options.base)
    distribution = _distribution(run, base)
    policy = SteeredPolicy(_network(base))
    played = _fingerprint(distribution)
    specs = [load_map(name) for name in distribution.maps]
    before = run.begin(played, {"base": "never"}, on_maps(specs))  # the steering is that of its weights
    response = BestResponse(policy, distribution, config)
    made = learn_response(response, run.folder, lambda told: run.tell(_line(told)))
    run.check_learned(before, RoundsMade(response.round, made), "--updates")
    partners = ", ".join(options.partners)
    training = base.card.training.model_copy(
        update={
            "preset": options.preset,
            "population": options.population or _population(base.card.training.population, partners),
            "updates": response.round,
            "seed": config.seed,
            "created": datetime.datetime.now(datetime.UTC).date().isoformat(),
            "items": run.items({pair for one in specs for pair in pairs_on(one)}, base.card),
        }
    )
    where = counted(len(specs), "map") + run.others_before()
    about = f"{base.card.name}, steered by reinforcement learning beside {partners} on {where}."
    maps = run.maps({one.name for one in specs}, base.card)  # by name, also own ones
    return Trained(save_policy(run.model_folder, run.agent_id, policy, maps, training, run.name, about), training)


def _population(before: str, partners: str) -> str:
    """Who is behind the weights, no longer than a card holds; a long beginning leaves room for the partners."""
    return shortened(f"{shortened(before, MAX_LINE // 2)}; then a best response to {partners}", MAX_LINE)


def _distribution(run: TrainingRun[ResponseConfig], base: Checkpoint) -> "EpisodeDistribution":
    """What is played. Raises AgentError or MapError for partners or maps that are not there.

    AgentError or WorldError too for a map with more than a partner or the policy sees.
    """
    from movingout.agents.reinforcement.rooms import EpisodeDistribution

    options = run.options
    maps = selected_maps(options.map)
    specs = [load_map(name) for name in maps]
    for spec in specs:
        check_undelivered(spec)
        LAYOUTS[base.card.network.layout].check(spec)
    run.caution(maps)
    if caution := test_people_caution(options.partners):
        run.tell(f"movingout: {caution}")
    groups = tuple(tuple(one.agent_id for one in group(name)) for name in options.partners)
    for agent_id in (one for name in options.partners for one in to_try(name)):
        run.load_agent(agent_id)  # fail now rather than in some round
    run.check_own_maps_seen((agent_id, spec) for ids in groups for agent_id in ids for spec in specs)
    if options.ticks < 1:
        raise DataError("--ticks must be at least 1")
    return EpisodeDistribution(tuple(maps), groups, options.ticks, run.load_agent)


def _fingerprint(distribution: "EpisodeDistribution") -> str:
    """The SHA-256 of the maps and the partners that are played: a list may have changed under the same name."""
    maps = [map_to_json(load_map(name)) for name in distribution.maps]
    return hashlib.sha256(json.dumps([maps, distribution.partners]).encode()).hexdigest()


def _network(base: Checkpoint) -> "DiffusionPolicy":
    """The policy of a checkpoint with its weights. Raises DataError for one that cannot be steered."""
    from movingout.agents.policies.diffusion_policy import DiffusionPolicy

    network = weighted_policy(base) if base.card.kind == "dp" else None
    if not isinstance(network, DiffusionPolicy):
        raise DataError(f"{base.card.id} is of kind {base.card.kind}; only policies of kind dp can be steered")
    return network.eval()


def _line(told: dict[str, float]) -> str:
    return ", ".join(f"{name} {value:.4g}" for name, value in told.items())


RESPONSE = AgentKind(
    name="response",
    from_recordings=False,
    example="--base dp@mine --map generated:training --partners families",
    summary="a best response to many partners: a policy steered by reinforcement learning",
    presets={"fast": ResponseConfig()},
    add_options=_add_options,
    option_names=("base", "map", "partners", "ticks"),
    train=_train,
    load=load_policy,
    saved_as="dp",
    check=check_policy,
)
