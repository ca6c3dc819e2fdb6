"""The kind `self-play`: a policy over options that learned by playing with itself, as it is and as it was early on."""

import argparse
import datetime
from collections.abc import Sequence
from typing import TYPE_CHECKING

from movingout.agents.agent_options import whole_number
from movingout.agents.base import Agent
from movingout.agents.checkpoint.card import Card, FileName, Training
from movingout.agents.checkpoint.checkpoint import Checkpoint, write_checkpoint
from movingout.agents.data.rollout import check_undelivered
from movingout.agents.errors import AgentError
from movingout.agents.kinds.kind import AgentKind, Trained
from movingout.agents.reinforcement.self_play_config import SelfPlayConfig
from movingout.agents.training.learned_data import on_maps
from movingout.agents.training.run import RoundsMade, TrainingRun, maps_sha256
from movingout.maps import MapSpec, load_map
from movingout.maps.commands.map_cautions import map_cautions
from movingout.maps.randomize import pairs_on
from movingout.maps.selection import HELP, selected_maps
from movingout.maps.suggestion import counted, known_names

if TYPE_CHECKING:
    from movingout.agents.reinforcement.self_play import SelfPlay

AGES: dict[str, FileName] = {"old": "policy.onnx", "young": "young.onnx"}


def load_self_play(checkpoint: Checkpoint, seed: int = 0, age: str = "old", temperature: float = 1.0) -> Agent:
    """The agent of a checkpoint, see `partners.options.player`. `age`: old, or young for the copy kept early on."""
    from movingout.agents.partners.options.player import OptionPlayer
    from movingout.agents.partners.options.trained import shared_scores

    check_self_play(checkpoint.card, seed, age, temperature)
    return OptionPlayer(shared_scores(checkpoint.read(AGES[age])), seed, temperature)


def check_self_play(card: Card, seed: int = 0, age: str = "old", temperature: float = 1.0) -> None:
    """Raises AgentError for options that `load_self_play` refuses."""
    from movingout.agents.partners.options.trained import checked_temperature

    whole_number("seed", seed)
    checked_temperature(temperature)
    if age not in AGES:
        raise AgentError(f"unknown age {age!r}; {known_names(str(age), AGES)}")


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--map", default="generated:training:300", help=f"what is played (default %(default)s): {HELP}")


def _train(run: TrainingRun[SelfPlayConfig]) -> Trained:
    """Play and learn in turns, then export the network, and the copy kept early on."""
    from movingout.agents.reinforcement.self_play import SelfPlay, learn_self_play

    config, maps = run.config, selected_maps(run.options.map)
    specs = [load_map(name) for name in maps]
    for one in specs:
        check_undelivered(one)
    run.caution(maps)
    for sentence in map_cautions(maps):
        run.tell(f"movingout: {sentence}")
    before = run.begin(maps_sha256(specs), learned=on_maps(specs))
    learner = SelfPlay(config, maps)
    learn_self_play(learner, run.folder, lambda told: run.tell(_line(told, config)))
    run.check_learned(before, RoundsMade(learner.round, learner.made), "--episodes")
    training = _training(run, learner, specs)
    others = run.others_before()
    return Trained(_saved(run, learner, [one.name for one in specs], training, others), training)


def _training(run: TrainingRun[SelfPlayConfig], learner: "SelfPlay", specs: Sequence[MapSpec]) -> Training:
    return Training(
        preset=run.options.preset,
        data_sha256=maps_sha256(specs),
        population=run.options.population or "its own play",
        episodes=learner.episodes,
        windows=learner.decisions,
        updates=learner.round,
        seed=run.config.seed,
        created=datetime.datetime.now(datetime.UTC).date().isoformat(),
        items=run.items({pair for one in specs for pair in pairs_on(one)}),
    )


def _saved(
    run: TrainingRun[SelfPlayConfig], learner: "SelfPlay", maps: Sequence[str], training: Training, others: str
) -> Checkpoint:
    from movingout.agents.policies.export import card_maps
    from movingout.agents.reinforcement.option_network import export_options
    from movingout.agents.reinforcement.self_play import read_early_network

    where = counted(len(maps), "map")
    about = (
        f"Chooses among options, carried out by a fixed controller; learned by self-play in "
        f"{learner.episodes:,} episodes on {where}{others}. Options: seed, age, temperature."
    )
    card = {
        "schema_version": 1, "id": run.agent_id, "name": run.name, "description": about, "kind": run.kind,
        "maps": card_maps(run.maps(maps)), "training": training.model_dump(),
    }  # fmt: skip
    networks = {"old": learner.network, "young": read_early_network(run.folder, run.config.width)}
    return write_checkpoint(
        run.model_folder, card, {AGES[age]: export_options(network) for age, network in networks.items()}
    )


def _line(told: dict[str, float], config: SelfPlayConfig) -> str:
    whole = config.rounds * config.round_episodes
    rest = ", ".join(f"{name} {value:.3g}" for name, value in told.items() if name != "episodes")
    return f"{told['episodes']:,.0f} of {counted(whole, 'episode')}, {rest}"


SELF_PLAY = AgentKind(
    name="self-play",
    summary="a policy over options (what to take, where to carry it) that learns by playing with itself",
    from_recordings=False,
    example="--map generated:training:300 --episodes 360",
    presets={"fast": SelfPlayConfig()},
    add_options=_add_options,
    option_names=("map",),
    train=_train,
    load=load_self_play,
    check=check_self_play,
    offered=False,
)
