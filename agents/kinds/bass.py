"""The kind `bass`: a simulator and a value on top of a policy, to choose among its candidates."""

import argparse
from typing import TYPE_CHECKING

from movingout.agents.base import Agent
from movingout.agents.bass.config import BassConfig
from movingout.agents.bass.options import check_live
from movingout.agents.checkpoint.checkpoint import Checkpoint
from movingout.agents.errors import DataError
from movingout.agents.kinds.bass_on_pictures import train_on_pictures
from movingout.agents.kinds.kind import AgentKind, Trained
from movingout.agents.training.run import Begun, TrainingRun
from movingout.agents.training.run_folder import begun, has_learned
from movingout.agents.training.training_data import TrainingData

if TYPE_CHECKING:
    from movingout.agents.bass.checkpoint_parts import TrainedProgress, TrainedSimulator, TrainedValue

_OF_SCORE = {
    "value": ("value_width", "value_members", "value_updates", "value_layout", "discount"),
    "tcl": ("progress_width", "progress_latent", "progress_updates"),
}
OF_SIMULATOR = "width", "latent", "residual", "rigid", "grasping", "updates", "epochs"
"""Fields that are for the training of a simulator alone."""


def load_bass(
    checkpoint: Checkpoint, execute: int = 0, simulator: str = "", partner: str = "policy",
    sampling: str | int = "", score: str = "", sub_steps: int = 0, mirrored: bool | str = False,
) -> Agent:  # fmt: skip
    """The agent of a checkpoint; the options are explained in `agents.bass.loading.bass_agent`."""
    from movingout.agents.bass.loading import bass_agent

    return bass_agent(
        checkpoint,
        execute,
        simulator=simulator,
        partner=partner,
        sampling=str(sampling),
        score=score,
        sub_steps=sub_steps,
        mirrored=mirrored,
    )  # `sampling=4` comes as a number


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--base", required=True, help="id of the policy that proposes the candidates")
    parser.add_argument(
        "--simulator", default="", help="id of a BASS agent whose simulator to reuse instead of training one"
    )
    parser.add_argument(
        "--value", default="", help="id of a BASS agent whose value network to reuse instead of training one"
    )


def _train(run: TrainingRun[BassConfig]) -> Trained:
    """Train or reuse the simulator and, for `score` value, the value network; write the checkpoint."""
    from movingout.agents.bass.checkpoint_parts import save_bass, simulator_of, value_of

    config, options = run.config, run.options
    base = run.find(options.base)
    _check(config, base, options)
    if (noted := begun(run.folder)) or not has_learned(run.folder):  # a folder without a configuration tells nothing
        check_used(config, options, noted)
    if base.card.network.picture:
        return train_on_pictures(run, base, _description(base, config))
    grasp = base.card.network.grasp
    simulator = simulator_of(run.find(options.simulator), config.depth, grasp) if options.simulator else None
    value = value_of(run.find(options.value)) if options.value else None
    learns_simulator = simulator is None and config.dynamics != "engine"
    learns_value = value is None and config.score == "value"
    progress: TrainedProgress | None = None
    trained = []
    if learns_simulator or learns_value or config.score == "tcl":
        data = _data(run, learns_value)
        before = run.begin_on(data, {name: "free" for name, _ in _unused(config, options)})
        if learns_simulator:
            simulator = _train_simulator(run, config, data, base, before)
            trained.append(simulator.training)
        if learns_value:
            value = _train_value(run, config, data, before, is_first=not trained)
            trained.append(value.training)
        if config.score == "tcl":
            progress = _train_progress(run, config, data, before, is_first=not trained)
            trained.append(progress.training)
    else:
        run.begin()
    checkpoint = save_bass(
        run.model_folder, run.agent_id, base, simulator, value, config, run.name, _description(base, config), progress
    )
    training = next((one for one in trained if one), checkpoint.card.training)
    return Trained(checkpoint, training)


def _check(config: BassConfig, base: Checkpoint, options: argparse.Namespace) -> None:
    """Raises DataError for options that do not go together."""
    horizon = base.card.network.horizon
    if config.depth > horizon:
        raise DataError(
            f"{options.base} predicts {horizon} ticks, so --depth {config.depth} is too far; --depth {horizon}"
        )
    if base.card.network.picture and not (
        config.dynamics == "vae" and config.score == "tcl" and config.order == "joint"
        and not options.simulator and not options.value
    ):  # fmt: skip
        raise DataError(
            f"{options.base} sees pictures, in which nothing tells the distance of items; take --score tcl, which is "
            "learned from them, and leave out --dynamics, --order, --simulator and --value"
        )
    if options.simulator and config.dynamics == "engine":
        raise DataError(f"--simulator {options.simulator} is for a learned simulator, not for --dynamics engine")
    if (
        config.decay != BassConfig.decay
        and (options.simulator or config.dynamics == "engine")
        and config.score != "tcl"
    ):
        raise DataError(
            "--decay is for the simulator and the embedding of --score tcl, neither of which is learned; leave it out"
        )
    if options.value and config.score != "value":
        raise DataError(f"--value {options.value} is for --score value, not for --score {config.score}")


def check_used(config: BassConfig, options: argparse.Namespace, before: Begun) -> None:
    """Raises DataError for options that were given and would do nothing; a run that began with them goes on."""
    for name, why in _unused(config, options):
        if name in options and before.get(name) != getattr(config, name):
            raise DataError(f"--{name.replace('_', '-')} is {why}; leave it out")


def _unused(config: BassConfig, options: argparse.Namespace) -> list[tuple[str, str]]:
    """Fields that do nothing in this training, and what each is for."""
    idle = [(name, f"for --score {score}, not for --score {config.score}")
            for score, names in _OF_SCORE.items() if score != config.score for name in names]  # fmt: skip
    if config.dynamics == "engine":
        idle += [(name, "for a learned simulator, not for --dynamics engine") for name in OF_SIMULATOR]
    if options.simulator:
        why = f"for a simulator that is trained, not for --simulator {options.simulator}"
        idle += [(name, why) for name in ("dynamics", "order", *OF_SIMULATOR)]
    if options.value:
        why = f"for a value network that is trained, not for --value {options.value}"
        idle += [(name, why) for name in _OF_SCORE["value"]]
    return idle


def _data(run: TrainingRun[BassConfig], learns_value: bool) -> TrainingData:
    """What is learned from. Raises DataError before anything is trained where a value cannot be learned from it."""
    from movingout.agents.bass.value_training import check_long_enough

    data = run.read_data()
    if learns_value:
        data.check_seen(run.config.value_layout)
        check_long_enough(data.episodes)
    return data


def _description(base: Checkpoint, config: BassConfig) -> str:
    by = "progress until then and what is expected to follow" if config.score == "value" else config.score.upper()
    what = "simulates with the game's engine" if config.dynamics == "engine" else "simulates"
    return (
        f"{base.card.name} with simulation and selection: {what} {config.own} candidates, each with "
        f"{config.partner} guesses of what the partner does, and plays the best by {by}."
    )


def _train_simulator(
    run: TrainingRun[BassConfig], config: BassConfig, data: TrainingData, base: Checkpoint, before: Begun
) -> "TrainedSimulator":
    from movingout.agents.bass.checkpoint_parts import packed_simulator
    from movingout.agents.bass.dynamics_training import train_dynamics, transitions_of

    transitions = transitions_of(data.episodes)
    run.tell("training the simulator")
    fitted = train_dynamics(config, transitions, run.folder)
    run.check_learned(before, fitted, "--updates")
    training = run.training(data, data.people, len(transitions), fitted.updates)
    return packed_simulator(fitted.network, config.depth, base.card.network.grasp, training)


def _train_value(
    run: TrainingRun[BassConfig], config: BassConfig, data: TrainingData, before: Begun, is_first: bool
) -> "TrainedValue":
    from movingout.agents.bass.checkpoint_parts import packed_value
    from movingout.agents.bass.value_training import returns_of, train_value

    returns = returns_of(data.episodes, config.discount, config.value_layout)
    run.tell("training the value network")
    fitted = train_value(config, returns, run.folder / "value")
    run.check_learned(before, fitted, "--value-updates", is_first)
    training = run.training(data, data.people, len(returns.returns), fitted.updates)
    return packed_value(fitted.network, training)


def _train_progress(
    run: TrainingRun[BassConfig], config: BassConfig, data: TrainingData, before: Begun, is_first: bool
) -> "TrainedProgress":
    from movingout.agents.bass.checkpoint_parts import packed_progress
    from movingout.agents.bass.progress_training import moments_of, train_progress

    moments = moments_of(data.episodes)
    run.tell("training the progress estimator")
    fitted = train_progress(config, moments, run.folder / "progress")
    run.check_learned(before, fitted, "--progress-updates", is_first)
    training = run.training(data, data.people, len(moments.rows), fitted.updates)
    return packed_progress(fitted.network, training)


BASS = AgentKind(
    name="bass",
    summary="BASS: a simulator, to choose among a policy's candidates",
    example="data/demos --base dp@mine",
    presets={
        "fast": BassConfig(),
        "paper": BassConfig(
            width=128,
            latent=32,
            residual=False,
            rigid=False,
            grasping=False,
            own=4,
            partner=4,
            combine="independent",
            score="nfd",
            depth=4,
            epochs=1000,
            warmup=0,
        ),
    },
    add_options=_add_options,
    option_names=("base", "simulator", "value"),
    train=_train,
    load=load_bass,
    check=check_live,
)
