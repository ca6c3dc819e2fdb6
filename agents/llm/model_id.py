"""Which model an id names, `llm:model=NAME,url=http://127.0.0.1:8080/v1`, and what is refused; opens no connection."""

from collections.abc import Iterable
from dataclasses import dataclass
from urllib.parse import urlsplit

from movingout.agents.around_others import acting_id
from movingout.agents.errors import AgentError

LLM = "llm"
COUNTED = "llm_"  # before what an agent counts in an episode
QUESTIONS, USEFUL = f"{COUNTED}questions", f"{COUNTED}useful"  # those with an outcome, and with a usable answer
KEY = "MOVINGOUT_LLM_KEY"
"""The environment variable with the endpoint's key. It is never recorded or logged."""
EXAMPLE = "llm:model=NAME,url=http://127.0.0.1:8080/v1"
MAX_NAME = 200  # characters


@dataclass(frozen=True, slots=True)
class ModelId:
    """A model behind an endpoint with the OpenAI chat API. `url` ends before `/chat/completions`."""

    model: str
    url: str


def endpoint_key(text: str) -> str:
    """The key in the environment variable, without space around it.

    Raises AgentError, without the key in it, for one that no request can have: clients would repeat it in their errors.
    """
    key = text.strip()
    if any(char.isspace() for char in key):
        raise AgentError(f"llm: the key in {KEY} has a space or a line break in it; set it to one key")
    if not (key.isascii() and key.isprintable()):
        raise AgentError(
            f"llm: the key in {KEY} has a character that no key has, maybe an invisible one; copy it again"
        )
    return key


def outrun(agent_id: str) -> str:
    """A sentence for matches, which outrun any answer; empty for an agent that waits, and for others."""
    kind, _, options = acting_id(agent_id).strip().partition(":")
    if kind != LLM or not options or "wait=" in options.replace(" ", ""):
        return ""
    return f"{agent_id} does not wait for its answers, and a match without people outruns them: add wait=yes."


def outrun_cautions(agent_ids: Iterable[str]) -> list[str]:
    """The sentence of each of these agents that has one, once."""
    return [sentence for agent_id in dict.fromkeys(agent_ids) if (sentence := outrun(agent_id))]


def model_id(model: object = "", url: object = "") -> ModelId:
    """Raises AgentError when one is missing, or when the address is none or has a key in it."""
    if not str(model).strip() or len(str(model)) > MAX_NAME:
        raise AgentError(f"llm: name the model as the server calls it, such as {EXAMPLE}")
    if not str(url).strip():
        raise AgentError(f"llm: name the address of a server with the OpenAI chat API, such as {EXAMPLE}")
    text = str(url).strip().rstrip("/").removesuffix("/chat/completions")
    try:
        parts = urlsplit(text)
        valid = parts.scheme in ("http", "https") and bool(parts.hostname) and parts.port != 0
    except ValueError:
        valid = False
    if not valid:
        raise AgentError(f"llm: {text!r} is no address of a server; it begins with http:// or https://")
    if parts.username or parts.password or parts.query or parts.fragment:
        raise AgentError(f"llm: addresses are recorded; a key goes into the environment variable {KEY}, not into url")
    return ModelId(str(model).strip(), text)
