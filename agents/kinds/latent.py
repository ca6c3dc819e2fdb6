"""The kind `latent`: a generative model of partners, learned from what partners did; it plays as whoever is drawn."""

import argparse
from typing import get_args

from movingout.agents.agent_options import ticks_between_decisions, whole_number
from movingout.agents.base import Agent
from movingout.agents.checkpoint.card import Card
from movingout.agents.checkpoint.checkpoint import Checkpoint
from movingout.agents.data.dataset import SeatChoice
from movingout.agents.generative.config import LatentConfig
from movingout.agents.generative.latent_option import parsed_latent
from movingout.agents.kinds.kind import AgentKind, Trained
from movingout.agents.training.run import TrainingRun
from movingout.maps.suggestion import counted


def load_latent(checkpoint: Checkpoint, seed: int = 0, z: object = "", execute: int = 0) -> Agent:
    """The agent of a checkpoint, see `generative.agent.LatentAgent`."""
    from movingout.agents.generative.agent import LatentAgent
    from movingout.agents.inference.network import shared_policy_network

    spec = checkpoint.card.network
    network = shared_policy_network(spec, checkpoint.read("policy.onnx"))
    return LatentAgent(spec, network, seed, z, execute)


def check_latent(card: Card, seed: int = 0, z: object = "", execute: int = 0) -> None:
    """Raises AgentError for options that `load_latent` refuses."""
    ticks_between_decisions(execute, card.network.horizon)
    whole_number("seed", seed)
    if z != "":
        parsed_latent(str(z), card.network.latent)


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--seats",
        choices=get_args(SeatChoice),
        default="acting",
        help="seats of recordings to learn from: acting (default; no idle seats and ghosts), human, or all; of files "
        "with an expert's labels, it is always the partner's seat",
    )


def _train(run: TrainingRun[LatentConfig]) -> Trained:
    """From episodes to a checkpoint: read, cut into windows, fit, export."""
    from movingout.agents.data.dataset import windows_of
    from movingout.agents.generative.training import train_latent
    from movingout.agents.policies.export import save_policy

    config, seats = run.config, run.options.seats
    config.check()
    spec, data = config.spec(run.kind), run.read_data()
    data.check_seen(spec.layout)
    before = run.begin_on(data)
    windows = windows_of(data.partners(spec, seats))
    fitted = train_latent(spec, config, windows, run.folder)
    run.check_learned(before, fitted, "--updates")
    training = run.training(data, windows.names, len(windows), fitted.updates)
    others, learned = run.others_before(), counted(training.episodes, "episode")
    about = f"Partners drawn from a model of {training.population}, trained on {learned}{others}. Options: seed, z."
    maps = run.maps({trajectory.map.name for trajectory in data.episodes})
    checkpoint = save_policy(run.model_folder, run.agent_id, fitted.network, maps, training, run.name, about)
    return Trained(checkpoint, training)


_OURS = LatentConfig(
    layout="relative-v1", lags="3,10,30", denoiser="items", restless=2.0, width=256, batch=512, updates=8000
)

LATENT = AgentKind(
    name="latent",
    summary="a generative model of partners, who differ by a latent vector",
    presets={"fast": _OURS},
    add_options=_add_options,
    option_names=("seats",),
    train=_train,
    load=load_latent,
    check=check_latent,
    offered=False,
)
