"""The options of an id of kind bass, checked by its card alone."""

from collections.abc import Mapping

from movingout.agents.agent_options import ticks_between_decisions, yes_or_no
from movingout.agents.checkpoint.card import Card, SelectionSpec
from movingout.agents.errors import AgentError, CheckpointError
from movingout.agents.inference.mirror import FeatureMirror
from movingout.agents.observation.features import FeatureSet

SAMPLINGS = {
    "4": {"own": 4, "partner": 4, "combine": "independent"},
    "2x2": {"own": 2, "partner": 2, "combine": "product"},
    "4x4": {"own": 4, "partner": 4, "combine": "product"},
    "8x2": {"own": 8, "partner": 2, "combine": "product"},
}
SIMULATIONS = (
    ("learned", "policy"), ("learned", "random"), ("learned", "none"), ("engine", "policy"), ("engine", "motion"),
    ("oracle", "policy"),
)  # fmt: skip
"""What simulates, and where the guesses of what the partner does come from."""
_CHOICES: dict[str, tuple[object, ...]] = {
    "sampling": tuple(SAMPLINGS),
    "score": ("nfd", "nfd+ac", "value", "tcl"),
    "sub_steps": (20, 10),
}


def check_live(
    card: Card, execute: int = 0, simulator: str = "", partner: str = "policy",
    sampling: str | int = "", score: str = "", sub_steps: int = 0, mirrored: bool | str = False,
) -> None:  # fmt: skip
    """Raises AgentError for options with which no agent can be made of the card, or none that plays with people."""
    selection = chosen_selection(card, str(sampling), score, sub_steps)
    simulates = simulator or selection.simulator
    if card.network.picture:
        check_picture(card, simulator, partner, selection)
    elif chosen_simulation(card, selection, simulator, partner)[0] == "oracle":
        raise AgentError(f"{card.id}: simulator=oracle needs the world itself, which matches without people have only")
    if yes_or_no("mirrored", mirrored):
        check_mirrored(card, simulates, selection)
    ticks_between_decisions(execute, card.network.horizon)


def chosen_selection(card: Card, sampling: str, score: str, sub_steps: int) -> SelectionSpec:
    """The card's selection with an id's options; "" and 0 are the card's. Raises AgentError."""
    base = card.selection
    if base is None:
        raise CheckpointError(f"checkpoint {card.id} is of kind bass but has no selection")
    if base.depth > card.network.horizon:
        raise CheckpointError(
            f"checkpoint {card.id} simulates {base.depth} ticks, but its policy predicts {card.network.horizon}"
        )
    options = {"sampling": sampling, "score": score, "sub_steps": sub_steps}
    return _changed(card, base, {name: value for name, value in options.items() if value})


def _changed(card: Card, base: SelectionSpec, changes: Mapping[str, object]) -> SelectionSpec:
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


def chosen_simulation(card: Card, selection: SelectionSpec, simulator: str, partner: str) -> tuple[str, str]:
    """One of SIMULATIONS. Raises AgentError."""
    chosen = selection.simulator if simulator == "" else simulator, partner
    if chosen not in SIMULATIONS:
        raise AgentError(
            f"{card.id}: simulator=learned, engine or oracle, partner=policy or, with a learned simulator, random or "
            f"none, with the engine, motion; not {', '.join(map(str, chosen))}"
        )
    if chosen[0] == "learned" and card.dynamics is None:
        raise AgentError(f"{card.id} has no learned simulator; use simulator=engine")
    return chosen


def check_picture(card: Card, simulator: str, partner: str, selection: SelectionSpec) -> None:
    """Raises AgentError for what an agent that sees pictures lacks: places of robots and items."""
    if simulator not in ("", "learned") or partner != "policy" or selection.score != "tcl":
        raise AgentError(
            f"{card.id} sees pictures: it takes simulator=learned, partner=policy and score=tcl only; "
            f"not {simulator or 'learned'}, {partner}, {selection.score}"
        )


def check_mirrored(card: Card, simulator: str, selection: SelectionSpec) -> None:
    """Raises AgentError where a part of the agent has no mirror: its policy, its simulator or its score."""
    FeatureMirror(FeatureSet.of(card.network))
    if simulator == "learned":
        raise AgentError(f"{card.id}: mirrored=yes is for simulator=engine; the learned simulator has no mirror")
    if selection.score == "tcl":
        raise AgentError(f"{card.id}: mirrored=yes is for score=value, nfd or nfd+ac; tcl has no mirror")
    if selection.score == "value" and card.value is not None:
        FeatureMirror(FeatureSet(card.value.layout))
