"""The next step of a participant, and what is skipped when the time of a block is up."""

from collections.abc import Collection

from movingout.study.design.definition import Study
from movingout.study.design.steps import Step

WAITING = "waiting"  # the place of somebody who waits for a partner; no step of the protocol
LAST_SOLO_STEP = "input-check"  # after this step the unit is formed


def next_step(
    order: tuple[Step, ...],
    key: str,
    over: Collection[str] = (),
    played: Collection[str] = (),
    unplayable: bool = False,
) -> Step:
    """The step after `key`.

    Of the blocks in `over`, whose time is up, only the questions about rounds in `played` (keys) remain; after a round
    that is `unplayable`, those about it do not, nor those about a partner who was met in no other one.
    """

    def remains(step: Step) -> bool:
        if step.kind == "questionnaire" and _asks_about(step.key, played):
            return True
        unmet = unplayable and step.kind == "questionnaire" and step.block and _asks_about(step.key, [key])
        return step.block not in over and not unmet

    keys = [step.key for step in order]
    return next(step for step in order[keys.index(key) + 1 :] if remains(step))


def blocks_over(study: Study, seconds: dict[str, float]) -> frozenset[str]:
    """The blocks whose time is up, counted from their first tick to the end of the newest round."""
    limits = {block.id: block.limit_minutes for block in study.blocks}
    return frozenset(
        block for block, lasted in seconds.items() if (limit := limits[block]) is not None and lasted >= limit * 60
    )


def _asks_about(key: str, played: Collection[str]) -> bool:
    """Whether a questionnaire is about one of these rounds, or about the partner of one."""
    parent = key.rpartition("/")[0]
    return any(one == parent or one.startswith(f"{parent}/") for one in played)
