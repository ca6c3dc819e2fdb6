"""The official JSON: each episode as the official collector saves it, and all of them as rows of its data set."""

import json
from collections import Counter
from typing import Any

from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings.episode import Episode
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.target import new_target
from movingout.recordings.official_format import dataset_row, recorder_steps


def write(plan: ExportPlan) -> None:
    """recorder/<Map>_<episode>.json, which the official replay script plays, and dataset.jsonl.

    A row of dataset.jsonl also says `episode_id`, `blue`, `red`, their kinds, `split`, `outcome`, `limit_ticks`, the
    `masses` of the items, which no state has, and, of a rehearsal, `simulated`; official loaders ignore that. An
    episode without ticks is left out: they expect a step.
    """
    numbers: Counter[str] = Counter()
    with new_target(plan.target) as folder:
        (folder / "recorder").mkdir(parents=True)
        with (folder / "dataset.jsonl").open("w", encoding="utf-8") as rows:
            for made in plan.converted(_converted, "exporting"):
                if made is None:
                    continue
                name, steps, row = made
                (folder / "recorder" / name).write_text(steps, encoding="utf-8")
                row["trajectory_id"] = numbers[row["map_name"]]
                numbers[row["map_name"]] += 1
                rows.write(json.dumps(row) + "\n")


def _converted(episode: Episode, part: str) -> tuple[str, str, dict[str, Any]] | None:
    """The name of the collector's file, its text, and the row of the data set; None without a tick."""
    if not episode.ticks:
        return None
    header = episode.header
    row = dataset_row(episode, 0) | {"episode_id": header.episode_id, "split": part}
    row |= {"outcome": episode.outcome, "limit_ticks": header.limit_ticks}
    row["masses"] = [item.mass for item in header.map.items]
    for colour, seat in zip(SEAT_COLOURS, header.seats, strict=True):
        row |= {colour: seat.name, f"{colour}_kind": seat.kind}
    if header.simulated:
        row["simulated"] = "yes"
    name = f"{header.map.file_name}_{header.episode_id}.json"
    return name, json.dumps([recorder_steps(episode)]), row
