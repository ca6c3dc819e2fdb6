"""The official JSON: each episode as the official collector saves it, and all of them as rows of its data set."""

import json
from collections import Counter

from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.target import new_target
from movingout.recordings.official_format import dataset_row, recorder_steps


def write(plan: ExportPlan) -> None:
    """recorder/<Map>_<episode>.json, which the official replay script plays, and dataset.jsonl.

    A row of dataset.jsonl also says `episode_id`, `blue`, `red`, their kinds and `split`; official loaders ignore that.
    """
    numbers: Counter[str] = Counter()
    with new_target(plan.target) as folder:
        (folder / "recorder").mkdir(parents=True)
        with (folder / "dataset.jsonl").open("w", encoding="utf-8") as rows:
            for episode, part in plan.episodes("exporting"):
                header = episode.header
                path = folder / "recorder" / f"{header.map.file_name}_{header.episode_id}.json"
                path.write_text(json.dumps([recorder_steps(episode)]), encoding="utf-8")
                row = dataset_row(episode, numbers[header.map.name])
                numbers[header.map.name] += 1
                row |= {"episode_id": header.episode_id, "split": part}
                for colour, seat in zip(SEAT_COLOURS, header.seats, strict=True):
                    row |= {colour: seat.name, f"{colour}_kind": seat.kind}
                rows.write(json.dumps(row) + "\n")
