"""`movingout cluster`: the proxy in front of several machines, what they are doing, and how many are needed."""

import argparse
import asyncio
import json
import math
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

from movingout.agents.live_options import check_live_agent
from movingout.maps.commands.parser import output_place
from movingout.server.cluster.capacity import FIGURES, plan, read_figures
from movingout.server.cluster.errors import ClusterError
from movingout.server.cluster.lease_store import ClusterView, LeaseStore, NodeRow
from movingout.server.cluster.proxy_config import TEMPLATES, ProxyConfig, ProxyLimits, command_line, nodes_of
from movingout.server.cluster.report import has_lease, unserved_study, waiting_rooms
from movingout.server.cluster.shards import SHARDS, STUDY
from movingout.server.settings import LEASE_S, at_once, lease

MOST_PRICE = 1e6


def configure(parser: argparse.ArgumentParser) -> None:
    commands = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    config = commands.add_parser(
        "config",
        help="write the configuration of HAProxy or Caddy in front of the nodes",
        example="movingout cluster config --node a=10.0.0.1:8000 --node b=10.0.0.2:8000 --domain game.example.org",
    )
    _add_config(config)
    status = commands.add_parser(
        "status",
        help="print the nodes, which rooms wait for one that is away, and why nobody serves the study",
        example="movingout cluster status --cluster postgresql://movingout@db/movingout",
    )
    status.add_argument("--cluster", required=True, metavar="URL", help="the PostgreSQL database of the cluster")
    status.add_argument(
        "--lease", type=lease, default=LEASE_S, metavar="S", help="what the nodes were started with (%(default)s)"
    )
    status.add_argument("--json", action="store_true", help="print one JSON document")
    status.set_defaults(work=_status)
    reckon = commands.add_parser(
        "plan",
        help="work out how many cores, and how much of the rest, participants need",
        example="movingout cluster plan --participants 1000 --agent bass@any",
    )
    _add_plan(reckon)


def run(args: argparse.Namespace) -> int:
    code: int = args.work(args)
    return code


def _add_config(parser: argparse.ArgumentParser) -> None:
    limits = ProxyLimits()
    parser.add_argument("--node", action="append", required=True, metavar="NAME=HOST:PORT", help="a node (repeatable)")
    parser.add_argument(
        "--for", dest="proxy", choices=[*TEMPLATES], default="haproxy", help="which proxy (%(default)s)"
    )
    parser.add_argument("--domain", default="", metavar="NAME", help="answer under this name only")
    parser.add_argument(
        "--certificate",
        default="",
        metavar="FILE",
        help="certificate and key in one PEM file, for https (Caddy gets its own without)",
    )
    parser.add_argument(
        "--listen",
        default="",
        metavar="ADDRESS",
        help="where to listen (:443, or :80 without https): a port alone is IPv4 and IPv6, 0.0.0.0:443 IPv4",
    )
    parser.add_argument(
        "--redirect-from", default=":80", metavar="ADDRESS", help="HAProxy sends http from here to https (:80)"
    )
    parser.add_argument(
        "--resolve-names",
        action="store_true",
        help="look for names of nodes in the DNS again and again: for pods and containers, which get other addresses",
    )
    parser.add_argument("--admin-socket", default="", metavar="FILE", help="HAProxy's own socket for its operator")
    parser.add_argument(
        "--max-connections",
        type=at_once,
        default=limits.connections,
        metavar="N",
        help="connections in all (%(default)s)",
    )
    parser.add_argument(
        "--max-per-address", type=at_once, default=limits.per_address, metavar="N",
        help="connections of one address, or /64 network (%(default)s); with more, it may also send more requests",
    )  # fmt: skip
    parser.add_argument("-o", "--out", type=output_place, metavar="FILE", help="write it here instead of printing it")
    parser.set_defaults(work=_config)


def _add_plan(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--participants", type=at_once, required=True, metavar="N", help="who play at the same time")
    parser.add_argument("--agent", default="", metavar="ID", help="the partner of each; without it they play in pairs")
    parser.add_argument(
        "--figures", type=Path, default=FIGURES, metavar="FILE", help="measured figures of your own (default: ours)"
    )
    parser.add_argument("--core-hour-price", type=price, metavar="PRICE", help="also print what the cores cost an hour")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.set_defaults(work=_plan)


def price(text: str) -> float:
    """A price in any currency. Raises ArgumentTypeError."""
    try:
        amount = float(text)
    except ValueError:
        amount = math.nan
    if not 0.0 <= amount <= MOST_PRICE:
        raise argparse.ArgumentTypeError(f"a price from 0 to {MOST_PRICE:,.0f} is possible, not {text}")
    return amount


def _plan(args: argparse.Namespace) -> int:
    if args.agent:
        check_live_agent(args.agent)
    figures = read_figures(args.figures)
    found = plan(args.participants, args.agent, figures)
    cost = {} if args.core_hour_price is None else {"cost_per_hour": round(found.cores * args.core_hour_price, 2)}
    if args.json:
        print(json.dumps({**asdict(found), **cost}, indent=2))
        return 0
    partner = f"with {found.agent}" if found.agent else "in pairs"
    who = "participant" if found.participants == 1 else "participants at the same time"
    print(f"{found.participants:,} {who}, {partner}:")
    for name, value in {**asdict(found), **cost}.items():
        if isinstance(value, int | float) and name != "participants":
            print(f"  {name.replace('_', ' '):<22}{value:>10,}")
    for note in found.notes:
        print(f"  {note}")
    print(f"Reckoned from {args.figures}:")
    for name in figures.__struct_fields__:
        print(f"  {name.replace('_', ' '):<26}{getattr(figures, name).source}")
    return 0


def _config(args: argparse.Namespace) -> int:
    config = ProxyConfig(
        nodes=nodes_of(args.node),
        domain=args.domain,
        certificate=args.certificate,
        listen=args.listen,
        redirect_from=args.redirect_from,
        admin_socket=args.admin_socket,
        resolve_names=args.resolve_names,
        limits=ProxyLimits.for_address(args.max_connections, args.max_per_address),
        command=command_line(),
    )
    text = config.text(args.proxy)
    if args.out is None:
        print(text, end="")
        return 0
    try:
        args.out.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ClusterError(f"cannot write {args.out}: {error.strerror}") from None
    print(f"wrote {args.out} for {len(config.nodes)} node{'s' * (len(config.nodes) > 1)}", file=sys.stderr)
    return 0


def _status(args: argparse.Namespace) -> int:
    """Exit code 1 when rooms wait for a node that is away, or when nobody serves the study."""

    async def look() -> ClusterView:
        store = LeaseStore(args.cluster, lease_s=args.lease)
        try:
            await store.refuse_without_nodes()
            return await store.view()
        finally:
            await store.close()

    view = asyncio.run(look())
    waiting = list(waiting_rooms(view, args.lease))
    rows = [_node_row(node, view) for node in view.nodes]
    unserved = [f"node {row['name']}: {row['problem']}" for row in rows if row["problem"]]
    unserved = unserved or [sentence for sentence in [unserved_study(view)] if sentence]
    if args.json:
        print(json.dumps({"nodes": rows, "waiting": waiting, "unserved": unserved}, indent=2))
    else:
        print(f"{'node':<16}{'state':<10}{'rooms':>6}  {'shards':<12}{'version':<10}address")
        for row in rows:
            runs = "  runs the study" if row["runs_study"] else ""
            print("{name:<16}{state:<10}{rooms:>6}  {shards:<12}{version:<10}{address}".format(**row) + runs)
        for sentence in (*unserved, *waiting):
            print(sentence)
    return 1 if waiting or unserved else 0


def _node_row(node: NodeRow, view: ClusterView) -> dict[str, Any]:
    """What is printed of a node, which is "away" when it neither renews its leases nor has ended."""
    study = view.lease(STUDY)
    return {
        "name": node.name,
        "state": node.state if node.alive or node.state == "ended" else "away",
        "rooms": node.rooms,
        "shards": "".join(lease.shard for lease in view.leases if lease.node == node.name and lease.shard in SHARDS),
        "runs_study": study is not None and has_lease(node, study) and not node.problem,
        "problem": node.problem if node.alive else "",
        "version": node.version,
        "address": node.address,
    }
