"""The agent of a checkpoint of kind bass, and the options of its id."""

from collections.abc import Mapping

from movingout.agents.bass.agent import BassAgent, RandomPartnerBassAgent, SingleAgentBassAgent
from movingout.agents.bass.engine_agent import EngineBassAgent, OracleBassAgent
from movingout.agents.bass.latent.picture_agent import PictureBassAgent
from movingout.agents.bass.partner_motion import MotionBassAgent
from movingout.agents.bass.progress import LearnedProgress
from movingout.agents.bass.score_functions import Estimator
from movingout.agents.bass.value import Value
from movingout.agents.checkpoint.card import Card, SelectionSpec
from movingout.agents.checkpoint.checkpoint import Checkpoint
from movingout.agents.errors import AgentError, CheckpointError
from movingout.agents.inference.network import shared_network, shared_policy_network

SAMPLINGS = {
    "4": {"own": 4, "partner": 4, "combine": "independent"},
    "2x2": {"own": 2, "partner": 2, "combine": "product"},
    "4x4": {"own": 4, "partner": 4, "combine": "product"},
    "8x2": {"own": 8, "partner": 2, "combine": "product"},
}
_CHOICES: dict[str, tuple[object, ...]] = {
    "sampling": tuple(SAMPLINGS),
    "score": ("nfd", "nfd+ac", "value", "tcl"),
    "sub_steps": (20, 10),
}


def bass_agent(
    checkpoint: Checkpoint, execute: int = 0, simulator: str = "", partner: str = "policy",
    sampling: str = "", score: str = "", sub_steps: int = 0,
) -> BassAgent:  # fmt: skip
    """The agent of a checkpoint of kind bass.

    Options for experiments: `simulator` learned, engine or oracle, `partner` policy, random, none or, with the engine,
    motion, `sampling` 4, 2x2, 4x4 or 8x2, `score` nfd, nfd+ac, value or tcl, `sub_steps` 20 or 10. The defaults are
    those of the card.
    """
    card = checkpoint.card
    if card.selection is None:
        raise CheckpointError(f"checkpoint {card.id} is of kind bass but has no selection")
    if card.selection.depth > card.network.horizon:
        raise CheckpointError(
            f"checkpoint {card.id} simulates {card.selection.depth} ticks, "
            f"but its policy predicts {card.network.horizon}"
        )
    changes = {"sampling": sampling, "score": score, "sub_steps": sub_steps}
    selection = _selection(card, card.selection, {name: value for name, value in changes.items() if value})
    if card.network.picture:
        return _picture_agent(checkpoint, execute, simulator, partner, selection)
    kind = _variant(card, card.selection.simulator if simulator == "" else simulator, partner)
    network = shared_policy_network(card.network, checkpoint.read("policy.onnx"))
    dynamics = None if issubclass(kind, EngineBassAgent) else shared_network(checkpoint.read("dynamics.onnx"))
    return kind(card.network, network, dynamics, selection, execute, _estimator(checkpoint, selection))


def _picture_agent(
    checkpoint: Checkpoint, execute: int, simulator: str, partner: str, selection: SelectionSpec
) -> BassAgent:
    """The agent of a checkpoint that sees pictures. Raises AgentError for what needs places of robots and items."""
    card = checkpoint.card
    if simulator not in ("", "learned") or partner != "policy" or selection.score != "tcl":
        raise AgentError(
            f"{card.id} sees pictures: it takes simulator=learned, partner=policy and score=tcl only; "
            f"not {simulator or 'learned'}, {partner}, {selection.score}"
        )
    policy, dynamics, progress = (checkpoint.read(f"{name}.onnx") for name in ("policy", "dynamics", "progress"))
    network = shared_policy_network(card.network, policy)
    return PictureBassAgent(
        card.network, network, shared_network(dynamics), shared_network(progress), selection, execute
    )


def _estimator(checkpoint: Checkpoint, selection: SelectionSpec) -> Estimator | None:
    """The network that scores states: for `tcl` the embedding, else the value if there is one."""
    card = checkpoint.card
    if selection.score == "tcl" and card.progress:
        return LearnedProgress(card.progress, shared_network(checkpoint.read("progress.onnx")))
    return Value(card.value, shared_network(checkpoint.read("value.onnx"))) if card.value else None


def _variant(card: Card, simulator: str, partner: str) -> type[BassAgent]:
    variants = {
        ("learned", "policy"): BassAgent,
        ("learned", "random"): RandomPartnerBassAgent,
        ("learned", "none"): SingleAgentBassAgent,
        ("engine", "policy"): EngineBassAgent,
        ("engine", "motion"): MotionBassAgent,
        ("oracle", "policy"): OracleBassAgent,
    }
    if (simulator, partner) not in variants:
        raise AgentError(
            f"{card.id}: simulator=learned, engine or oracle, partner=policy or, with a learned simulator, random or "
            f"none, with the engine, motion; not {simulator}, {partner}"
        )
    if simulator == "learned" and card.dynamics is None:
        raise AgentError(f"{card.id} has no learned simulator; use simulator=engine")
    return variants[simulator, partner]


def _selection(card: Card, base: SelectionSpec, changes: Mapping[str, object]) -> SelectionSpec:
    """The card's selection with an id's options. Raises AgentError."""
    for name, value in changes.items():
        if value not in _CHOICES[name]:
            raise AgentError(f"{card.id}: {name} is one of {', '.join(map(str, _CHOICES[name]))}, not {value}")
    score = changes.get("score", base.score)
    if score == "value" and card.value is None:
        raise AgentError(f"{card.id} has no value network; train it with --score value, or use score=nfd")
    if score == "tcl" and card.progress is None:
        raise AgentError(f"{card.id} has no progress network; train it with --score tcl, or use score=nfd")
    update = {name: value for name, value in changes.items() if name != "sampling"}
    update |= SAMPLINGS.get(str(changes.get("sampling")), {})
    return base.model_copy(update=update)
