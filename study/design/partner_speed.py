"""Whether the partners of a study decide within a tick on this machine: each is timed on a map that it is met on."""

from dataclasses import replace

from movingout.agents.errors import AgentError
from movingout.agents.trial import NotReadyError, decision_ms
from movingout.recordings.progress import with_progress
from movingout.study.design.definition import Study
from movingout.study.design.review import Review, agent_ids, first_map
from movingout.world.constants import TICK_MS


def partners_timed(found: Review) -> Review:
    """The same once the partners were timed; this takes seconds."""
    return replace(found, slow=slow_partners(found.study))


def slow_partners(study: Study, progress: bool = True) -> tuple[str, ...]:
    """A sentence for each partner whose decisions take longer than a tick; with `progress` a terminal shows a bar.

    Those that cannot be made or cannot play are left out: others say that.
    """
    names = agent_ids(study)
    shown = with_progress(names, len(names), "timing partners") if progress else names
    return tuple(filter(None, (_slowness(study, name) for name in shown)))


def _slowness(study: Study, agent_id: str) -> str:
    the_map = first_map(study, agent_id)
    try:
        needed = decision_ms(agent_id, study.map_source(the_map))
    except NotReadyError as error:
        return (
            f"{error}: take a faster machine or another partner; study serve --slow-agents begins all the same, but "
            "its rounds wait for it no longer than that"
        )
    except AgentError:
        return ""
    if needed is None or needed <= TICK_MS:
        return ""
    return (
        f"{agent_id} needs {needed:.0f} ms for a decision on {the_map} on this machine, and a tick has {TICK_MS} ms: "
        "take a faster machine or another partner; with study serve --slow-agents it plays all the same, and misses "
        "ticks"
    )
