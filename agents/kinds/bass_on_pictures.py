"""Training BASS on a policy that sees pictures: its simulator and its progress learn from the same pictures."""

from movingout.agents.bass.config import BassConfig
from movingout.agents.checkpoint.checkpoint import Checkpoint
from movingout.agents.kinds.kind import Trained
from movingout.agents.training.run import TrainingRun


def train_on_pictures(run: TrainingRun[BassConfig], base: Checkpoint, description: str) -> Trained:
    """Read, draw, fit both networks, write the checkpoint."""
    from movingout.agents.bass.checkpoint_parts import packed_picture_progress, packed_picture_simulator, save_bass
    from movingout.agents.bass.latent.picture_training import (
        picture_sequences,
        train_picture_dynamics,
        train_picture_progress,
    )

    config, data = run.config, run.read_data()
    sequences = picture_sequences(data.episodes, base.card.network)
    before = run.begin_on(data)
    run.tell("training the simulator on pictures")
    simulated = train_picture_dynamics(config, sequences, run.folder)
    run.check_learned(before, simulated, "--updates")
    training = run.training(data, data.people, len(sequences), simulated.updates)
    simulator = packed_picture_simulator(simulated.network, config.depth, training)
    run.tell("training the progress estimator on pictures")
    embedded = train_picture_progress(config, sequences, run.folder / "progress")
    run.check_learned(before, embedded, "--progress-updates", is_first=False)
    progress = packed_picture_progress(
        embedded.network, run.training(data, data.people, len(sequences), embedded.updates)
    )
    checkpoint = save_bass(
        run.model_folder, run.agent_id, base, simulator, None, config, run.name, description, progress
    )
    return Trained(checkpoint, training)
