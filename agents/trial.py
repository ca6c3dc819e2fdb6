"""An agent plays, or decides, in another process: what only its own code shows, without running it here."""

import os
import subprocess
import sys

from movingout.agents.around_others import acting_id
from movingout.agents.built_in import AROUND_OTHERS, BUILT_IN
from movingout.agents.catalogue import id_parts
from movingout.agents.errors import AgentError
from movingout.agents.llm.model_id import LLM
from movingout.agents.worker.thread_budget import ONE_THREAD
from movingout.recordings.recorded_seat import GHOST

_AT_ONCE = ("idle", GHOST, LLM)  # agents that compute nothing here, and one whose answers no tick waits for
LOADING_LIMIT_S = 90.0  # for an agent to be made, here and in a server's worker
_OURS = "movingout: "  # begins the sentence of a command


class NotReadyError(AgentError):
    """It took too long, which another map would not change."""


def runs_own_code(agent_id: str) -> bool:
    """Whether the agent may be somebody's own: a class, a policy of another library, one of an installed package.

    One around another agent counts as such. Raises AgentError for an id that is none.
    """
    reference, options = id_parts(agent_id)
    if reference in AROUND_OTHERS and "agent" in options:  # `late:agent=my_agent:Mine`
        return True
    ours = reference in BUILT_IN or reference in (LLM, GHOST) or reference.startswith("movingout.")
    return not ours and "@" not in reference


def play_a_tick(agent_id: str, the_map: str) -> None:
    """Raises AgentError for an agent that cannot be made, or not play on the map (a name or a file)."""
    words = "agents", "probe", agent_id, "--map", the_map, "--ticks", "1", "--json"
    command = [sys.executable, "-P", "-m", "movingout.server.cli", *words]
    try:
        played = subprocess.run(
            command, capture_output=True, encoding="utf-8", errors="replace", timeout=LOADING_LIMIT_S
        )
    except subprocess.TimeoutExpired as late:
        if late.stdout:  # it has played, but a thread that the agent started keeps its process alive
            return
        raise NotReadyError(f"the partner {agent_id} was not ready within {LOADING_LIMIT_S:.0f} s") from None
    if played.stdout:  # its times, also where the first decision takes longer than a tick
        return
    said = [line.removeprefix(_OURS) for line in played.stderr.splitlines() if line.startswith(_OURS)]
    if not said:
        raise AgentError(f"making the partner {agent_id} ended its process ({played.returncode})")
    raise AgentError(said[-1] if agent_id in said[-1] else f"the partner {agent_id} cannot play: {said[-1]}")


def decision_ms(agent_id: str, the_map: str) -> float | None:
    """The median decision on the map (a name or a file) in a process like a server's worker; None where none was made.

    None too for agents whose decisions no tick waits for. Raises NotReadyError.
    """
    if acting_id(agent_id).strip().partition(":")[0] in _AT_ONCE:
        return None
    command = [sys.executable, "-P", "-m", "movingout.agents.decision_time", agent_id, the_map]
    with_one_thread = {**os.environ, **ONE_THREAD}
    try:
        timed = subprocess.run(command, capture_output=True, env=with_one_thread, timeout=LOADING_LIMIT_S)
    except subprocess.TimeoutExpired:
        raise NotReadyError(f"the partner {agent_id} was not ready within {LOADING_LIMIT_S:.0f} s") from None
    try:
        return None if timed.returncode else float(timed.stdout.split()[-1])  # libraries may have written before
    except (IndexError, ValueError):  # the agent has ended its process
        return None
