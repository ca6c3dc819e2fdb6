"""`movingout agents`: list, show, check, probe, quantize and weakness."""

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from dataclasses import asdict

import numpy as np
from rich.console import Console
from rich.padding import Padding
from rich.table import Table

from movingout.agents.base import THREADS
from movingout.agents.baseline.idle import IdleAgent
from movingout.agents.baseline.timed_agent import TimedAgent
from movingout.agents.built_in import AgentCard
from movingout.agents.catalogue import (
    UNSEEN_NFD,
    UNSEEN_TCR,
    agent_card,
    agent_cards,
    damaged_cards,
    load_agent,
    unseen_map,
)
from movingout.agents.checkpoint.checkpoint import find_checkpoint, model_roots
from movingout.agents.checkpoint.onnx_interface import Shapes
from movingout.agents.commands import weakness
from movingout.agents.conformance import MAPS, TICKS, Conformance, ConformanceError, check_agent
from movingout.agents.data.rollout import check_undelivered, rollout
from movingout.agents.errors import AgentError
from movingout.agents.fault_place import located
from movingout.agents.hash_seeds import process_problem
from movingout.agents.llm.agent import SILENT
from movingout.agents.llm.first_answer import FirstAnswer, first_answer
from movingout.agents.trial import runs_own_code
from movingout.maps import MapSpec, load_map
from movingout.maps.commands.parser import add_out
from movingout.maps.commands.sentences import tell
from movingout.maps.extras import needs_extra
from movingout.maps.files.ctrl_c import FOREIGN_CODE_RAISES, is_ctrl_c, noticing_ctrl_c
from movingout.maps.files.terminal import printable, printable_lines
from movingout.maps.suggestion import counted
from movingout.world.constants import LIMIT_TICKS, TICK_MS, TICKS_PER_SECOND


def configure(parser: argparse.ArgumentParser) -> None:
    commands = parser.add_subparsers(dest="action", metavar="COMMAND", required=True, title="commands")
    listing = commands.add_parser(
        "list", help="built-in agents, and those with a checkpoint", example="movingout agents list"
    )
    listing.set_defaults(perform=_list)
    show = commands.add_parser(
        "show", help="one agent: what it does, its maps and its scores", example="movingout agents show bass@all"
    )
    show.set_defaults(perform=_show)
    probe = commands.add_parser(
        "probe", help="time its decisions beside an idle partner", example="movingout agents probe dp@all --map HandOff"
    )
    probe.add_argument("--map", default="HandOff", help="a map's name or file (HandOff)")
    probe.add_argument("--ticks", type=int, default=200, help="length of the episode (200)")
    probe.set_defaults(perform=_probe)
    check = commands.add_parser(
        "check",
        help="check that it meets the rules for agents; exit code 1 if not",
        example="movingout agents check my_package.mine:Agent",
    )
    check.add_argument("--map", default=",".join(MAPS), help="map names joined by commas (%(default)s)")
    check.add_argument(
        "--ticks", type=int, help=f"length of each episode (default: {TICKS}, and at the end one of {LIMIT_TICKS})"
    )
    check.set_defaults(perform=_check)
    quantize = commands.add_parser(
        "quantize",
        help="store trained agents with weights of 8 bits, for half the space",
        example="movingout agents quantize dp@mine bass@mine --out small",
    )
    quantize.add_argument("agents", nargs="+", metavar="ID", help="trained agents; a network in common is stored once")
    quantize.add_argument(
        "--keep-weights", action="store_true", help="keep the weights they were made from too, for `train --start`"
    )
    add_out(quantize, "DIR", "folder for their folders", required=True)
    quantize.set_defaults(perform=_quantize)
    worst = commands.add_parser(
        "weakness",
        help="search a model of partners for those with which an agent does worst",
        example="movingout agents weakness dp@any --map HandOff -o worst.txt",
    )
    weakness.configure(worst)
    worst.set_defaults(perform=weakness.perform)
    for command in (show, check, probe):
        command.add_argument("agent", metavar="ID", help="an id of the list, or package.module:Factory")
    for command in (listing, show, check, probe):
        command.add_argument("--json", action="store_true", help="one JSON document on standard output")


def run(arguments: argparse.Namespace) -> int:
    perform: Callable[[argparse.Namespace], int] = arguments.perform
    return perform(arguments)


def _list(arguments: argparse.Namespace) -> int:
    cards = agent_cards()
    for sentence in damaged_cards():
        tell(f"left out: {sentence}")
    if arguments.json:
        print(json.dumps({"agents": [_document(card) for card in cards]}))
        return 0
    console, rows = Console(highlight=False, markup=False), [_row(card) for card in cards]
    (_print_in_columns if _fits_in_columns(rows, console.width) else _print_in_paragraphs)(console, rows)
    console.print(
        "\nTCR and NFD: with scripted people it never met, by its card; – where its card has none.", style="dim"
    )
    return 0


def _fits_in_columns(rows: Sequence[Sequence[str]], width: int) -> bool:
    """Whether descriptions have room for their words beside the other columns, which are not cut."""
    others = zip(_HEADINGS[:-1], *(row[:-1] for row in rows), strict=True)
    return sum(max(map(len, column)) + 2 for column in others) + _DESCRIPTION_WIDTH <= width


def _print_in_columns(console: Console, rows: Sequence[Sequence[str]]) -> None:
    table = Table(*_HEADINGS, box=None, header_style="dim", pad_edge=False)
    for column in table.columns[:-1]:
        column.no_wrap = True
    for row in rows:
        table.add_row(*row)
    console.print(table)


def _print_in_paragraphs(console: Console, rows: Sequence[Sequence[str]]) -> None:
    """In a narrow terminal: each id is whole, on a line of its own."""
    for id, kind, maps, tcr, nfd, description in rows:
        console.print(id, soft_wrap=True)
        for text in (f"{kind}, maps: {maps}, TCR {tcr}, NFD {nfd}", description):
            console.print(Padding(text, (0, 0, 0, 4)))


def _show(arguments: argparse.Namespace) -> int:
    card = agent_card(arguments.agent)
    load_agent(arguments.agent)  # checks its options now rather than in a game
    reference = arguments.agent.partition(":")[0]
    trained = find_checkpoint(reference, *model_roots()) if "@" in reference else None
    networks = trained.networks() if trained else {}
    if arguments.json:
        files = {name: {"inputs": taken, "outputs": given} for name, (taken, given) in networks.items()}
        print(json.dumps({**_document(card), "networks": files}))
        return 0
    print(printable_lines(f"{card.name}  ({card.id}, {card.kind})\n{card.description}\nmaps: {card.maps}"))
    if card.scores:
        print(f"scores: {_scores(card)}")
    if trained:
        print(f"folder: {trained.folder}")
    for name, (taken, given) in networks.items():
        print(printable(f"{name}: {_shapes(taken)} → {_shapes(given)}"))
    return 0


def _check(arguments: argparse.Namespace) -> int:
    if arguments.ticks is not None and arguments.ticks < 1:
        raise AgentError(f"an episode has at least 1 tick, not {arguments.ticks}")
    agent = load_agent(arguments.agent)  # an id that names nothing is a wrong command, not a fault of the agent
    maps = arguments.map.split(",")
    with redirect_stdout(sys.stderr):  # what the agent prints
        answered = first_answer(agent, maps[0])
    problems = _no_answer(answered)
    if problems and getattr(agent, "waits", False):  # it would wait as long for each question of the check
        return _say_problem(arguments, f"{problems[0]}; its rules were not checked")
    try:
        with redirect_stdout(sys.stderr):
            found = check_agent(lambda: load_agent(arguments.agent), maps, arguments.ticks)
        if found.deterministic and runs_own_code(arguments.agent):
            problems += filter(None, [process_problem(arguments.agent, maps[0], arguments.ticks)])
    except ConformanceError as error:
        return _say_problem(arguments, "; ".join([*problems, str(error)]))
    if problems:
        return _say_problem(arguments, "; ".join(problems))
    _say_found(arguments, maps, answered, found)
    return 0


def _say_found(
    arguments: argparse.Namespace, maps: Sequence[str], answered: FirstAnswer | None, found: Conformance
) -> None:
    if arguments.json:
        decision_ms = {"p50": found.p50_ms, "p99": found.p99_ms, "n": len(found.decisions_ms)}
        document = {"id": arguments.agent, "conforms": True, "ticks": found.ticks, "decision_ms": decision_ms}
        print(json.dumps(document | ({"answer_s": answered.latency_s} if answered else {})))
    else:
        if answered:
            print(f"Its model answered a question in {answered.latency_s:.1f} s: {answered.plan}")
        seen = f"{len(found.decisions_ms)} decisions in {found.episodes} episodes of up to {found.ticks} ticks on "
        seen += ", ".join(maps)
        print(f"{arguments.agent} meets the rules: {seen}, p50 {found.p50_ms:.1f} ms, p99 {found.p99_ms:.1f} ms")
        if not found.deterministic:
            print("Its answers were not compared: it is not deterministic.")


def _say_problem(arguments: argparse.Namespace, problem: str) -> int:
    if arguments.json:
        print(json.dumps({"id": arguments.agent, "conforms": False, "problem": problem}))
    else:
        print(printable_lines(f"{arguments.agent}: {problem}"))
    return 1


def _no_answer(answered: FirstAnswer | None) -> list[str]:
    """A sentence where an agent's language model gave no answer of use."""
    if answered is None or not answered.problem:
        return []
    return [f"its model gave no usable answer to {counted(SILENT, 'question')} ({answered.problem})"]


def _probe(arguments: argparse.Namespace) -> int:
    if arguments.ticks < 1:
        raise AgentError(f"an episode has at least 1 tick, not {arguments.ticks}")
    timed, the_map = TimedAgent(load_agent(arguments.agent)), load_map(arguments.map)
    check_undelivered(the_map)
    if caution := unseen_map(arguments.agent, the_map.name):
        tell(caution)
    ticks = _probed_ticks(arguments, timed, the_map)
    p50, p99 = np.percentile(timed.decisions_ms, (50, 99)).tolist()
    holds = p99 < TICK_MS
    if arguments.json:
        decision_ms = {"p50": p50, "p99": p99, "n": len(timed.decisions_ms)}
        document = {"id": arguments.agent, "map": arguments.map, "ticks": ticks, "decision_ms": decision_ms}
        print(json.dumps({**document, "threads": THREADS, "holds_10hz": holds}))
    else:
        verdict = f"{'holds' if holds else 'too slow for'} {TICKS_PER_SECOND} Hz on this machine"
        print(f"{arguments.agent} on {arguments.map}: {len(timed.decisions_ms)} decisions in {ticks} ticks, ", end="")
        print(f"p50 {p50:.1f} ms, p99 {p99:.1f} ms of {TICK_MS} ms: {verdict}")
    return 0 if holds else 1


def _probed_ticks(arguments: argparse.Namespace, timed: TimedAgent, the_map: MapSpec) -> int:
    """Let it play; returns for how many ticks. Raises AgentError for whatever it raises."""
    with noticing_ctrl_c():
        try:
            with redirect_stdout(sys.stderr):  # what the agent prints
                return sum(1 for _ in rollout(the_map, (timed, IdleAgent()), seed=0, ticks=arguments.ticks))
        except AgentError:
            raise
        except FOREIGN_CODE_RAISES as error:
            if is_ctrl_c(error):
                raise
            raise AgentError(located(f"{arguments.agent} raised {type(error).__name__}: {error}", error)) from error


def _quantize(arguments: argparse.Namespace) -> int:
    with needs_extra("train", "quantizing"):
        from movingout.agents.checkpoint.quantization import write_quantized
    for agent_id in arguments.agents:
        checkpoint = find_checkpoint(agent_id, *model_roots())
        small = write_quantized(checkpoint, arguments.out, arguments.keep_weights)
        before, now = (sum(one.stat().st_size for one in each.folder.iterdir()) for each in (checkpoint, small))
        common = {entry.of for entry in small.card.files if entry.of}
        beside = f", with networks of {', '.join(sorted(common))}" if common else ""
        print(f"{agent_id}: {before / 1e6:.1f} MB, now {now / 1e6:.1f} MB in {small.folder}{beside}")
    print("Other weights, other play: measure them again. Their cards have no scores.")
    return 0


_HEADINGS = ("agent", "kind", "maps", "TCR", "NFD", "what it does")
_DESCRIPTION_WIDTH = 20  # at least, in columns


def _row(card: AgentCard) -> tuple[str, ...]:
    scores = [f"{card.scores[name]:.2f}" if name in card.scores else "–" for name in (UNSEEN_TCR, UNSEEN_NFD)]
    return (card.id, card.kind, card.maps, *scores, card.description)


def _scores(card: AgentCard) -> str:
    return ", ".join(f"{name} {mean:.3f}" for name, mean in card.scores.items())


def _shapes(values: Shapes) -> str:
    """`observation (batch, 1, 491)`; a length that is left open and is not the batch is "any", whatever its name."""
    named = {name: [length if length == "batch" or isinstance(length, int) else "any" for length in shape]
             for name, shape in values.items()}  # fmt: skip
    return ", ".join(f"{name} ({', '.join(map(str, lengths))})" for name, lengths in named.items())


def _document(card: AgentCard) -> dict[str, object]:
    return {**asdict(card), "scores": dict(card.scores)}
