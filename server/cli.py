"""The console script `movingout`: a table of sub-commands, each imported only when it is asked for."""

import argparse
import atexit
import codecs
import importlib
import io
import os
import sys
import threading
import time
from typing import NamedTuple, Protocol, cast

import movingout
from movingout.maps.commands.parser import CommandParser
from movingout.maps.commands.sentences import tell
from movingout.maps.errors import MovingOutError
from movingout.maps.suggestion import known_names
from movingout.server.drain_signal import hold_back
from movingout.server.security.passwords import password_warning


class Command(NamedTuple):
    module: str
    help: str
    example: str


class CommandModule(Protocol):
    """What a sub-command's module offers."""

    def configure(self, parser: argparse.ArgumentParser) -> None: ...

    def run(self, args: argparse.Namespace) -> int: ...


COMMANDS = {
    "play": Command(
        "movingout.server.commands.play",
        "serve the game in the browser",
        "movingout play --host 0.0.0.0 --tls",
    ),
    "match": Command(
        "movingout.matches.commands.match",
        "play agent-vs-agent matches without a screen",
        "movingout match --red bass@all --blue person:name=C03 --map HandOff",
    ),
    "demos": Command(
        "movingout.agents.commands.demos",
        "let scripted people play and record them",
        "movingout demos people",
    ),
    "train": Command(
        "movingout.agents.commands.train",
        "train an agent from recordings, or from its own play",
        "movingout train dp --help",
    ),
    "agents": Command(
        "movingout.agents.commands.agents",
        "list, show, probe and check agents",
        "movingout agents list",
    ),
    "maps": Command(
        "movingout.maps.commands.maps",
        "list, show, check, render and randomize maps",
        "movingout maps show HandOff",
    ),
    "paper": Command(
        "movingout.matches.commands.paper",
        "make the paper's tables and figures, beside its own",
        "movingout paper tables tab:ablation --dry-run",
    ),
    "recordings": Command(
        "movingout.agents.commands.recordings",
        "list, verify, view, report, export and import recordings",
        "movingout recordings list",
    ),
    "study": Command(
        "movingout.server.study.commands.study",
        "write and check study files; serve them; report, export and forget their data",
        "movingout study new",
    ),
    "cluster": Command(
        "movingout.server.cluster.commands.cluster",
        "several machines: the proxy in front of them, and what they are doing",
        "movingout cluster config --node a=10.0.0.1:8000 --node b=10.0.0.2:8000 --domain game.example.org",
    ),
    "loadtest": Command(
        "movingout.server.commands.loadtest",
        "measure the server with bots that speak the real protocol",
        "movingout loadtest --rooms 10",
    ),
    "doctor": Command(
        "movingout.server.commands.doctor",
        "check this machine and this installation",
        "movingout doctor",
    ),
    "completion": Command(
        "movingout.server.commands.completion",
        "print a script that completes commands and options in your shell",
        "movingout completion bash > ~/.local/share/bash-completion/completions/movingout",
    ),
}

WITH_AGENTS = ("agents", "match", "demos")  # commands that may run agents of one's own in this process
THREADS_S = 3.0  # how long threads that agents leave behind may still run


def main(argv: list[str] | None = None) -> int:
    """Run one sub-command. Exit code 0 done, 1 the check failed, 2 wrong use or bad input."""
    arguments = sys.argv[1:] if argv is None else argv
    if argv is None:
        hold_back(arguments)
    code = 1  # where an exception ends it
    try:
        code = _run(arguments)
        return code
    finally:
        if argv is None and arguments and arguments[0] in WITH_AGENTS:
            threading.Thread(target=_end_despite_threads, args=(code,), daemon=True).start()


def _end_despite_threads(code: int) -> None:
    """End this process if it still waits, in a while, for threads that go on, perhaps for ever.

    Runs beside Python's own ending, in which pools end their threads.
    """
    time.sleep(THREADS_S)
    left = [one for one in threading.enumerate() if not one.daemon and one is not threading.main_thread()]
    if left:
        names = ", ".join(dict.fromkeys(thread.name for thread in left))
        print(f"movingout: not waiting for threads that an agent left running: {names}", file=sys.stderr)
        atexit._run_exitfuncs()
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def _run(arguments: list[str]) -> int:
    # Read when torch is imported: threads of a training that wait for each other sleep. By default they spin, and where
    # other programs want the cores, too, that takes most of the time.
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
    _prepare_output()
    try:
        try:
            code = _perform(arguments)
        except SystemExit:  # as after --help
            sys.stdout.flush()
            raise
        sys.stdout.flush()
        return code
    except MovingOutError as error:
        tell(str(error))  # it may quote a file that others made
        try:
            sys.stdout.flush()
        except OSError:
            _drop_output()
        return 2
    except KeyboardInterrupt:
        print("movingout: stopped", file=sys.stderr)
        return 130
    except OSError as error:
        problem = _output_problem() if error.filename is None else None
        if problem is None:
            raise
        if isinstance(problem, BrokenPipeError):  # as after `| head`
            return 1
        print(f"movingout: cannot write to standard output: {problem.strerror or problem}", file=sys.stderr)
        return 2


def _prepare_output() -> None:
    """What is printed goes nowhere where that is closed (`>&-`); names that are not UTF-8 are escaped, as in errors.

    Some terminals say that they have 0 columns, in which tables would have no room: the width is unknown then.
    """
    if os.environ.get("COLUMNS") == "0":
        del os.environ["COLUMNS"]
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
    if isinstance(sys.stdout, io.TextIOWrapper):
        refuses = ("strict",) if _takes_all(sys.stdout.encoding) else ("strict", "surrogateescape")  # in a C locale
        if sys.stdout.errors in refuses:
            sys.stdout.reconfigure(errors="backslashreplace")


def _takes_all(encoding: str) -> bool:
    """Whether every letter can be written so; what `surrogateescape` then escapes is a name's own bytes."""
    return codecs.lookup(encoding).name == "utf-8"


def _perform(arguments: list[str]) -> int:
    if not arguments or arguments[0].startswith("-"):
        _top_parser().parse_args(arguments or ["--help"])  # ends the program
    if arguments[0] not in COMMANDS:
        print(f"movingout: unknown command {arguments[0]!r}; {known_names(arguments[0], COMMANDS)}", file=sys.stderr)
        return 2
    command, parser = configured(arguments[0])
    args = parser.parse_args(arguments[1:])
    if warning := password_warning(args):
        print(warning, file=sys.stderr)
    return command.run(args)


def _output_problem() -> OSError | None:
    """Why standard output takes nothing more, if that is so: nobody reads it, its disk is full. The rest is dropped."""
    try:
        print(flush=True)
    except OSError as error:
        _drop_output()
        return error
    return None


def _drop_output() -> None:
    """What could not be written, or Python complains when it ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def configured(name: str) -> tuple[CommandModule, CommandParser]:
    """A command's module, imported now, and its parser."""
    module, help, example = COMMANDS[name]
    parser = CommandParser(prog=f"movingout {name}", description=f"{help[:1].upper()}{help[1:]}.", example=example)
    command = cast(CommandModule, importlib.import_module(module))
    command.configure(parser)
    return command, parser


class _Version(argparse.Action):
    """Prints the version of the installed package, which is looked up only now."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        print(f"movingout {movingout.__version__}")
        parser.exit()


def _top_parser() -> argparse.ArgumentParser:
    parser = CommandParser(
        prog="movingout",
        description="People and agents carry things together: play, record, evaluate.",
        example="movingout play",
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    choices = parser.add_subparsers(metavar="COMMAND", title="commands")
    for name, command in COMMANDS.items():
        choices.add_parser(name, help=command.help, add_help=False)
    return parser


if __name__ == "__main__":
    sys.exit(main())
