"""Which layout of observations a policy was trained with: named by the user, by the file, or known from its size."""

from movingout.agents.errors import AgentError
from movingout.world.observation import LAYOUTS

LAYOUT_KEY = "movingout.layout"
"""Where a file can say it: a property of an ONNX model's metadata, an extra file of a TorchScript archive."""


def chosen_layout(named: str, size: int | None, said: str = "") -> str:
    """The layout: `named` by the user, `said` by the file, or the one of `size` numbers (None where nobody knows).

    Raises AgentError for an unknown name, for one that does not fit the size, and when nothing says it.
    """
    name = named or said or _of_size(size)
    if name not in LAYOUTS:
        by = "" if named else " named by the file"
        raise AgentError(f"unknown layout {name!r}{by}; known: {known_layouts()}")
    if size is not None and LAYOUTS[name].size != size:
        raise AgentError(f"the policy takes {size} numbers, {name} has {LAYOUTS[name].size}; known: {known_layouts()}")
    return name


def known_layouts() -> str:
    """`official-v1 (121 numbers), …`"""
    return ", ".join(f"{layout.name} ({layout.size} numbers)" for layout in LAYOUTS.values())


def _of_size(size: int | None) -> str:
    if size is None:
        raise AgentError(f"the file does not say its layout; add layout=NAME: {known_layouts()}")
    for layout in LAYOUTS.values():
        if layout.size == size:
            return layout.name
    raise AgentError(f"the policy takes {size} numbers, which is no layout: {known_layouts()}")
