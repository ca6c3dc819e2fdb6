"""Agents that are files: `onnx:path=…`, `torchscript:path=…`, `sb3:path=…`, `lerobot:path=…`; imports none of them."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from movingout.agents.errors import AgentError


@dataclass(frozen=True, slots=True)
class PolicyFileKind:
    """A kind of file that can take a seat."""

    name: str
    title: str
    factory: str  # "module:attribute", imported when asked for
    what: str  # that its path names
    suffix: str = ""  # of its files


_KINDS = (
    PolicyFileKind("onnx", "ONNX", "movingout.agents.adapters.onnx_agent:OnnxAgent", "an .onnx file", ".onnx"),
    PolicyFileKind(
        "torchscript",
        "TorchScript",
        "movingout.agents.adapters.torchscript_agent:TorchScriptAgent",
        "a file of torch.jit.save",
        ".pt",
    ),
    PolicyFileKind(
        "sb3", "Stable-Baselines3", "movingout.agents.adapters.sb3_agent:Sb3Agent", "a .zip of model.save", ".zip"
    ),
    PolicyFileKind(
        "lerobot", "LeRobot", "movingout.agents.adapters.lerobot_agent:LeRobotAgent", "a folder pretrained_model"
    ),
)
POLICY_FILES: Mapping[str, PolicyFileKind] = {kind.name: kind for kind in _KINDS}


class MissingPackageError(AgentError):
    """A file needs a library that is not installed."""

    def __init__(self, kind: str, package: str, install: str) -> None:
        title = POLICY_FILES[kind].title
        super().__init__(f"a policy of {title} needs the package {package}; install it with: pip install {install}")


def existing(kind: str, path: object, folder: bool = False) -> Path:
    """The file or folder that an option `path` names. Raises AgentError when there is none."""
    wanted = Path(str(path)).expanduser()
    if wanted.is_dir() if folder else wanted.is_file():
        return wanted
    there = f"{wanted} is a {'file' if folder else 'folder'}" if wanted.exists() else f"there is no {wanted}"
    raise AgentError(f"{there}; {kind}:path= names {POLICY_FILES[kind].what}")


def id_of_file(path: str) -> str:
    """The id of the agent that a file is, by its suffix; empty where there is no such file."""
    kind = next((kind.name for kind in _KINDS if kind.suffix and path.endswith(kind.suffix)), "")
    try:
        return f"{kind}:path={path}" if kind and Path(path).expanduser().is_file() else ""
    except (OSError, RuntimeError):  # too long, not to be looked at, or of a user who is not here
        return ""


def policy_file(agent_id: str) -> Path | None:
    """The file or folder of an agent that is one, whether it exists or not; None for any other agent."""
    kind, _, options = agent_id.strip().partition(":")
    if kind not in POLICY_FILES:
        return None
    named = [part.partition("=") for part in options.split(",")]
    paths = [value.strip() for key, _, value in named if key.strip() == "path"]
    return Path(paths[0]).expanduser() if paths else None
