"""The card of an exported data set: README.md in the form that dataset hubs read."""

import json
from collections import Counter
from importlib.metadata import version

import yaml

from movingout.recordings.episode import ROOM_PSEUDONYM, SeatInfo
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.split import TRAIN, caution, has_room_names
from movingout.recordings.storage.listing import Players
from movingout.world.constants import TICK_SECONDS
from movingout.world.observation import LAYOUTS

CARD = "README.md"
FILES = {
    "parquet": {name: f"{name}.parquet" for name in ("episodes", "ticks", "events")},
    "csv": {name: f"{name}.csv" for name in ("episodes", "ticks", "events")},
    "lerobot": {"default": "data/*/*.parquet"},
    "official": {"default": "dataset.jsonl"},
}
"""The formats that are folders with a card, and the files of each of their tables."""
_ABOUT = {
    "parquet": "Three tables, described in DATA_DICTIONARY.md; `episode_id` joins them.",
    "csv": "Three tables, described in DATA_DICTIONARY.md; `episode_id` joins them.",
    "lerobot": 'A LeRobotDataset v3.0: `LeRobotDataset("local/name", root=FOLDER)`.',
    "official": "Trajectories in the layout of the official Moving Out code: `recorder/` and `dataset.jsonl`.",
}
_KINDS = {"human": "people", "agent": "agents", "remote": "remote programs", "ghost": "repeated recordings"}


def dataset_card(name: str, plan: ExportPlan) -> str:
    """The card of what was exported in the format `name`, as Markdown with YAML at its head."""
    parts = Counter(plan.splits)
    training, testing = parts[TRAIN], len(plan.recordings) - parts[TRAIN]
    lines = [
        "---",
        yaml.safe_dump(_head(name), sort_keys=False).rstrip(),
        "---",
        "",
        "# Moving Out episodes",
        "",
        "Two robots, driven by people or agents, carry items to goal regions in a 2D physical world: the benchmark",
        f"of the paper *Moving Out: Physically-grounded Human-AI Collaboration*. {_ABOUT[name]}",
        "",
        "| | |",
        "|---|---|",
        f"| {'recordings' if name == 'lerobot' else 'episodes'} | {len(plan.recordings)}: {training} for training, "
        f"{testing} for testing |",
        *_episodes(name, plan),
        f"| split | by {plan.split_by}, seed {plan.seed} |",
        f"| maps | {_counted(Counter(plan.map_names))} |",
        f"| seats | {_counted(_kinds(plan.players))} |",
        f"| time | a row per tick of {TICK_SECONDS} s |",
        *_vectors(name, plan),
        f"| made by | `movingout recordings export --to {name}`, version {version('moving-out-live')} |",
        "",
        *_same_names(plan),
        "**People.** Participants appear under pseudonyms only. Publish what they agreed to have published.",
        *_room_names(plan),
        "",
        "**Licence.** None is stated. Add `license:` at the head of this file before you publish it.",
    ]
    return "\n".join(lines) + "\n"


def _head(name: str) -> dict[str, object]:
    files = [{"config_name": table, "data_files": files} for table, files in FILES[name].items()]
    tags = ["moving-out", "human-ai-collaboration", "multi-agent", *(["LeRobot"] if name == "lerobot" else [])]
    return {"pretty_name": "Moving Out episodes", "task_categories": ["robotics"], "tags": tags, "configs": files}


def _episodes(name: str, plan: ExportPlan) -> list[str]:
    """How many episodes LeRobot counts: one for each seat; a recording without a tick has none."""
    if name != "lerobot":
        return []
    info = json.loads((plan.target / "meta" / "info.json").read_text(encoding="utf-8"))
    return [
        f"| episodes | {info['total_episodes']}, one {'with both actions' if plan.view == 'joint' else 'per seat'} |"
    ]


def _same_names(plan: ExportPlan) -> list[str]:
    return [f"**Maps.** {' '.join(plan.one_name_sentences)}", ""] if plan.one_name_sentences else []


def _room_names(plan: ExportPlan) -> list[str]:
    """What somebody who splits the data needs to know, too; of two parts where a split was asked for."""
    if plan.test_share and (sentence := caution(plan.players, plan.split_by)):
        return [f"{sentence}."]
    always = f"A name `{ROOM_PSEUDONYM}…` is of one room: one person may have several."
    return [always] if has_room_names(plan.players) else []


def _vectors(name: str, plan: ExportPlan) -> list[str]:
    if name not in ("parquet", "lerobot"):
        return []
    view = f", view `{plan.view}`" if name == "lerobot" else ""
    rows = [f"| observations | layout `{plan.layout}`{view} |"]
    if name == "lerobot" and LAYOUTS[plan.layout].own_frame:
        whose = "blue's" if plan.view == "joint" else "the robot's own"
        rows.append(f"| actions | headings relative to {whose} angle before the tick, as the observation |")
    return rows


def _kinds(players: list[Players]) -> Counter[str]:
    return Counter(_kind(seat, one.simulated) for one in players for seat in one.seats)


def _kind(seat: SeatInfo, simulated: bool) -> str:
    """Programs that took part in a rehearsal of a study are not to pass for people."""
    return "simulated people" if simulated and seat.kind == "human" else _KINDS.get(seat.kind, seat.kind)


def _counted(numbers: Counter[str]) -> str:
    return ", ".join(f"{what} ({number})" for what, number in sorted(numbers.items()))
