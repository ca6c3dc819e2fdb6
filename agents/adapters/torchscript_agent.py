"""A TorchScript file in a seat: `torchscript:path=policy.pt,layout=map-v1`. It contains code: load only your own."""

import warnings
from typing import Any

import numpy.typing as npt

from movingout.agents.adapters.chunk_player import Singles, VectorPlayer
from movingout.agents.adapters.layout_choice import LAYOUT_KEY, chosen_layout
from movingout.agents.adapters.policy_file import MissingPackageError, existing
from movingout.agents.errors import AgentError

try:
    import torch

    from movingout.agents.adapters.torch_state import TorchState
except ImportError as error:
    raise MissingPackageError("torchscript", "torch", "torch") from error


class TorchScriptAgent(VectorPlayer):
    """The module takes observations (1, D), with `history` (1, To, D), and answers with (1, 4) or (1, H, 4)."""

    def __init__(
        self,
        path: str,
        layout: str = "",
        history: int = 0,
        execute: int = 0,
        grasp: str = "toggle",
        headings: str = "",
    ) -> None:
        """`layout` may be left out where the archive says it (extra file `movingout.layout`); `history` 0: (1, D).

        Raises AgentError: no such file, no TorchScript, wrong sizes.
        """
        if type(history) is not int or not 0 <= history <= 64:
            raise AgentError(f"history is a whole number of observations from 1 to 64, not {history}")
        self._torch = TorchState()
        self._module, said = _loaded(path)
        self._flat = history == 0
        super().__init__(chosen_layout(layout, None, said), max(history, 1), execute, grasp, headings=headings)
        self._try(self._infer)

    def _start(self) -> None:
        super()._start()
        self._torch.reset(self.episode)

    def _infer(self, seen: Singles) -> npt.ArrayLike:
        with self._torch.in_use(), torch.inference_mode():
            answer = self._module(torch.from_numpy(seen if self._flat else seen[None]))
        if not isinstance(answer, torch.Tensor):
            raise AgentError(f"the module answers with {type(answer).__name__}, not a tensor")
        numbers: npt.ArrayLike = answer.float().cpu().numpy()
        return numbers


def _loaded(path: str) -> tuple[Any, str]:
    """The module on the CPU, and the layout that its archive names."""
    file = existing("torchscript", path)
    extra = {LAYOUT_KEY: ""}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)
            module: Any = torch.jit.load(  # type: ignore[no-untyped-call]
                str(file), map_location="cpu", _extra_files=extra
            )
    except (RuntimeError, ValueError) as error:
        raise AgentError(f"{file} is not a TorchScript file; write it with torch.jit.save") from error
    said = extra[LAYOUT_KEY]
    return module.eval(), said.decode() if isinstance(said, bytes) else said
