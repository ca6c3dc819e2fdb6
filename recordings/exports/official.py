"""The official JSON: each episode as the official collector saves it, and all of them as rows of its data set."""

import json
from collections import Counter

from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.target import new_target
from movingout.recordings.official_format import dataset_row, recorder_steps


def write(plan: ExportPlan) -> None:
    """recorder/<Map>_<episode>.json, which the official replay script plays, and dataset.jsonl.

    A row of dataset.jsonl also says `episode_id`, `blue`, `red` and `split`, which official loaders ignore.
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
                row |= {"blue": header.seats[0].name, "red": header.seats[1].name}
                rows.write(json.dumps(row) + "\n")
