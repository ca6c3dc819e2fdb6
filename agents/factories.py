"""From `module:attribute` to what makes an agent; what an agent prints meanwhile goes to standard error."""

import importlib
import inspect
import sys
from collections.abc import Callable
from contextlib import redirect_stdout
from pathlib import Path
from types import ModuleType
from typing import cast

from movingout.agents.errors import AgentError
from movingout.agents.fault_place import located
from movingout.maps.files.ctrl_c import FOREIGN_CODE_RAISES, is_ctrl_c, noticing_ctrl_c


def factory_at(reference: str) -> Callable[..., object]:
    """The class or function of `module:attribute`. Raises AgentError when it cannot be imported or called."""
    module_name, _, attribute = reference.partition(":")
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.append(here)  # your module may lie in the current folder; it never shadows an installed one
    with noticing_ctrl_c():
        try:
            with redirect_stdout(sys.stderr):
                module = importlib.import_module(module_name)
            return _called(module_name, module, attribute)
        except AgentError:
            raise
        except FOREIGN_CODE_RAISES as error:
            if is_ctrl_c(error):
                raise
            raise AgentError(located(f"cannot import {module_name!r}: {_words(error)}", error)) from error


def _words(error: BaseException) -> str:
    """Of whatever somebody's module raises while it is imported."""
    if isinstance(error, SystemExit):  # a script that reads its command line, say
        return "it ends the program while it is imported; put what it does as a script under if __name__ == '__main__':"
    words = error.msg if isinstance(error, SyntaxError) else str(error)  # its own have the place, which ours add
    return f"{type(error).__name__}: {words}"


def _called(module_name: str, module: ModuleType, attribute: str) -> Callable[..., object]:
    factory = getattr(module, attribute, None)
    if factory is None:
        raise AgentError(f"{module_name!r} has no factory {attribute!r}")
    if not callable(factory):
        kind = type(factory).__name__
        raise AgentError(f"{attribute!r} in {module_name!r} is a {kind}, not a class or a function that makes agents")
    return cast(Callable[..., object], factory)


def check_methods(made: object, maker: str) -> None:
    """Raises AgentError when what `maker` made is no agent: `reset` and `act` are missing, or would answer later."""
    if inspect.iscoroutine(made):
        made.close()
        raise AgentError(f"{maker} is async; what makes an agent is a plain function or a class")
    for name in ("reset", "act"):
        method = getattr(made, name, None)
        if not callable(method):
            raise AgentError(f"{maker} returns {type(made).__name__}, which has no {name}()")
        if inspect.iscoroutinefunction(method):
            raise AgentError(f"{name}() of {type(made).__name__} is async; nobody awaits it, so write a plain def")
