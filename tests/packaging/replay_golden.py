"""Replays golden episodes with the installed distribution and says which do not end bit for bit as they should.

Usage: `python replay_golden.py GOLDEN_EPISODE.py FOLDER`; exit code 1 when any differs. Stands alone, because it runs
where the tests are not importable.
"""

import importlib.util
import sys
from pathlib import Path


def main(module_file: str, folder: str) -> int:
    spec = importlib.util.spec_from_file_location("golden_episode", module_file)
    assert spec is not None and spec.loader is not None
    golden_episode = importlib.util.module_from_spec(spec)
    sys.modules["golden_episode"] = golden_episode
    spec.loader.exec_module(golden_episode)
    files = sorted(Path(folder).glob("*.npz"))
    different = []
    for path in files:
        expected = golden_episode.load(path)
        played = golden_episode.play(expected.map_name, expected.actions, expected.pymunk)
        if (played.hashes != expected.hashes).any():
            different.append(path.stem)
    sys.stdout.write(f"{len(files) - len(different)} of {len(files)} identical; different: {different}\n")
    return 1 if different or not files else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
