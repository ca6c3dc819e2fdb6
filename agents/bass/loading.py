"""The agent of a checkpoint of kind bass."""

from movingout.agents.agent_options import yes_or_no
from movingout.agents.bass.agent import BassAgent, RandomPartnerBassAgent, SingleAgentBassAgent
from movingout.agents.bass.engine_agent import EngineBassAgent, OracleBassAgent
from movingout.agents.bass.latent.picture_agent import PictureBassAgent
from movingout.agents.bass.options import check_mirrored, check_picture, chosen_selection, chosen_simulation
from movingout.agents.bass.partner_motion import MotionBassAgent
from movingout.agents.bass.progress import LearnedProgress
from movingout.agents.bass.score_functions import Estimator
from movingout.agents.bass.value import Value
from movingout.agents.checkpoint.card import SelectionSpec
from movingout.agents.checkpoint.checkpoint import Checkpoint
from movingout.agents.inference.mirror import FeatureMirror
from movingout.agents.inference.network import check_size, shared_network, shared_policy_network
from movingout.agents.observation.features import FeatureSet
from movingout.world.observation import LAYOUTS

_CLASSES: dict[tuple[str, str], type[BassAgent]] = {
    ("learned", "policy"): BassAgent,
    ("learned", "random"): RandomPartnerBassAgent,
    ("learned", "none"): SingleAgentBassAgent,
    ("engine", "policy"): EngineBassAgent,
    ("engine", "motion"): MotionBassAgent,
    ("oracle", "policy"): OracleBassAgent,
}


def bass_agent(
    checkpoint: Checkpoint, execute: int = 0, simulator: str = "", partner: str = "policy",
    sampling: str = "", score: str = "", sub_steps: int = 0, mirrored: bool | str = False,
) -> BassAgent:  # fmt: skip
    """The agent of a checkpoint of kind bass.

    Options for experiments: `simulator` learned, engine or oracle, `partner` policy, random, none or, with the engine,
    motion, `sampling` 4, 2x2, 4x4 or 8x2, `score` nfd, nfd+ac, value or tcl, `sub_steps` 20 or 10, `mirrored` yes or
    no (`agents.inference.mirror`). The defaults are those of the card.
    """
    card = checkpoint.card
    selection = chosen_selection(card, sampling, score, sub_steps)
    if through := yes_or_no("mirrored", mirrored):
        check_mirrored(card, simulator or selection.simulator, selection)
    if card.network.picture:
        check_picture(card, simulator, partner, selection)
        return _picture_agent(checkpoint, execute, selection)
    kind = _CLASSES[chosen_simulation(card, selection, simulator, partner)]
    network = shared_policy_network(card.network, checkpoint.read("policy.onnx"))
    dynamics = None if issubclass(kind, EngineBassAgent) else shared_network(checkpoint.read("dynamics.onnx"))
    return kind(
        card.network, network, dynamics, selection, execute, _estimator(checkpoint, selection, through), through
    )


def _picture_agent(checkpoint: Checkpoint, execute: int, selection: SelectionSpec) -> BassAgent:
    """The agent of a checkpoint that sees pictures."""
    spec = checkpoint.card.network
    policy, dynamics, progress = (checkpoint.read(f"{name}.onnx") for name in ("policy", "dynamics", "progress"))
    network = shared_policy_network(spec, policy)
    return PictureBassAgent(spec, network, shared_network(dynamics), shared_network(progress), selection, execute)


def _estimator(checkpoint: Checkpoint, selection: SelectionSpec, mirrored: bool) -> Estimator | None:
    """The network that scores states: for `tcl` the embedding, else the value if there is one."""
    card = checkpoint.card
    if selection.score == "tcl" and card.progress:
        return LearnedProgress(card.progress, shared_network(checkpoint.read("progress.onnx")))
    if card.value is None:
        return None
    network, layout = shared_network(checkpoint.read("value.onnx")), card.value.layout
    check_size(network, "features", LAYOUTS[layout].size, layout)
    return Value(card.value, network, FeatureMirror(FeatureSet(layout)) if mirrored else None)
