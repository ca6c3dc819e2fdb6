"""The kinds that learn from their own play alone: MAPPO, and CoMeDi on top of it."""

import argparse
import datetime
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar, get_args

from movingout.agents.agent_options import noise_factor
from movingout.agents.base import Agent
from movingout.agents.checkpoint.card import Card, Training
from movingout.agents.checkpoint.checkpoint import Checkpoint
from movingout.agents.data.rollout import check_undelivered
from movingout.agents.kinds.kind import AgentKind, Trained
from movingout.agents.reinforcement.mappo_config import ON_COORDINATION, PAPER, ComediConfig, MappoConfig
from movingout.agents.training.learned_data import on_maps
from movingout.agents.training.run import RoundsMade, TrainingRun, maps_sha256
from movingout.maps import MapSpec, load_map
from movingout.maps.commands.map_cautions import map_cautions
from movingout.maps.randomize import Pair, Split, pairs_on, variant_pairs
from movingout.maps.selection import HELP, selected_maps
from movingout.maps.suggestion import counted

if TYPE_CHECKING:
    from movingout.agents.reinforcement.mappo import Mappo

ConfigT = TypeVar("ConfigT", bound=MappoConfig)
Learn = Callable[[TrainingRun[ConfigT], ConfigT, Sequence[str], Split | None], "Sequence[Mappo]"]
"""Learns on maps; what plays is the last one."""


def load_sampling(checkpoint: Checkpoint, noise: float = 1.0) -> Agent:
    """The agent of a checkpoint. `noise`: 1 draws actions as in training, 0 plays the middle of what it would draw."""
    from movingout.agents.inference.network import shared_policy_network
    from movingout.agents.reinforcement.sampling_agent import SamplingAgent

    spec = checkpoint.card.network
    return SamplingAgent(spec, shared_policy_network(spec, checkpoint.read("policy.onnx")), noise)


def check_sampling(card: Card, noise: float = 1.0) -> None:
    """Raises AgentError for options that `load_sampling` refuses."""
    noise_factor(noise)


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--map", default="HandOff", help=f"what is played (default %(default)s): {HELP}")
    parser.add_argument(
        "--split", choices=get_args(Split), default=None, help="play another Challenge 2 variant in every episode"
    )
    parser.add_argument("--ray", default="", metavar="auto|ADDRESS", help="play on a Ray cluster (extra `cluster`)")


def _train(learn: Learn[ConfigT], run: TrainingRun[ConfigT]) -> Trained:
    """Play and learn in turns, then export the actor."""
    options = run.options
    maps = selected_maps(options.map)
    specs = [load_map(name) for name in maps]
    for one in specs:
        check_undelivered(one)
    config = _for_maps(run, maps)
    run.caution(maps)
    for sentence in map_cautions(maps):
        run.tell(f"movingout: {sentence}")
    before = run.begin(maps_sha256(specs), learned=on_maps(specs, _pairs(specs, options.split)))
    if config.whole_frames != config.frames:
        run.tell(f"{config.frames:,} frames become {config.whole_frames:,}: {counted(config.rounds, 'whole round')}")
    learned = learn(run, config, maps, options.split)
    progress = RoundsMade(sum(one.round for one in learned), sum(one.made for one in learned))
    run.check_learned(before, progress, "--frames")
    others = run.others_before()
    return _exported(run, config, specs, learned, others)


def _exported(
    run: TrainingRun[ConfigT], config: ConfigT, specs: Sequence[MapSpec], learned: "Sequence[Mappo]", others: str
) -> Trained:
    """The checkpoint of the last one; `others`: of what it learned before, for the description."""
    from movingout.agents.policies.export import save_policy

    last, frames = learned[-1], sum(one.frames for one in learned)
    maps = [one.name for one in specs]  # not the paths of own maps: matches are asked by name
    where = f"{len(maps)} maps" if len(maps) > 1 else maps[0]
    training = Training(
        preset=run.options.preset,
        data_sha256=maps_sha256(specs),
        population=run.options.population or "its own play",
        episodes=sum(one.episodes for one in learned),
        windows=frames,
        updates=sum(one.round for one in learned),
        seed=config.seed,
        created=datetime.datetime.now(datetime.UTC).date().isoformat(),
        items=run.items(_pairs(specs, run.options.split)),
    )
    about = f"{_TITLES[run.kind]} on {where}{others}: {frames:,} ticks of its own play, reward {config.reward}."
    checkpoint = save_policy(run.model_folder, run.agent_id, last.actor, run.maps(maps), training, run.name, about)
    return Trained(checkpoint, training)


def _pairs(specs: Sequence[MapSpec], split: Split | None) -> set[Pair]:
    """Sizes and shapes that lie on the maps that are played."""
    return {pair for one in specs for pair in (variant_pairs(one, split) if split else pairs_on(one))}


def _for_maps(run: TrainingRun[ConfigT], maps: Sequence[str]) -> ConfigT:
    """The configuration; the paper has other numbers on maps of coordination, unless the command line says some."""
    if run.options.preset != "paper" or any(load_map(name).mode != "coordination" for name in maps):
        return run.config
    return replace(
        run.config, **{name: value for name, value in ON_COORDINATION.items() if name not in vars(run.options)}
    )


def _mappo(
    run: TrainingRun[MappoConfig], config: MappoConfig, maps: Sequence[str], split: Split | None
) -> "list[Mappo]":
    from movingout.agents.reinforcement.mappo import Mappo, learn_mappo

    mappo = Mappo(config, config.spec(run.kind), maps, split, ray=run.options.ray)
    learn_mappo(mappo, run.folder, lambda told: run.tell(_line(told, config)))
    return [mappo]


def _comedi(
    run: TrainingRun[ComediConfig], config: ComediConfig, maps: Sequence[str], split: Split | None
) -> "list[Mappo]":
    from movingout.agents.reinforcement.comedi import learn_comedi

    def tell(name: str, told: dict[str, float]) -> None:
        run.tell(f"{name}: {_line(told, config)}")

    return learn_comedi(config, config.spec(run.kind), maps, split, run.folder, tell, run.options.ray)


def _line(told: dict[str, float], config: MappoConfig) -> str:
    rest = ", ".join(f"{name} {value:.4g}" for name, value in told.items() if name != "frames")
    return f"{told['frames']:,.0f} of {config.whole_frames:,} frames, {rest}"


_TITLES = {"mappo": "MAPPO", "comedi": "CoMeDi"}


def _self_play(name: str, summary: str, config: type[ConfigT], learn: Learn[ConfigT]) -> AgentKind[ConfigT]:
    return AgentKind(
        name=name,
        summary=summary,
        from_recordings=False,
        example="--map HandOff",
        presets={"fast": config(), "paper": config(**PAPER)},
        add_options=_add_options,
        option_names=("map", "split"),
        train=lambda run: _train(learn, run),
        load=load_sampling,
        check=check_sampling,
    )


MAPPO = _self_play("mappo", "MAPPO: both seats learn from rewards by self-play", MappoConfig, _mappo)
COMEDI = _self_play(
    "comedi",
    "CoMeDi: conventions that differ, learned one after another, and an answer to all of them",
    ComediConfig,
    _comedi,
)
