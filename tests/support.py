"""What tests of several folders share: where the reference data of the official environment lies."""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
REFERENCE = ROOT.parent / "shared" / "reference"


def reference(name: str) -> Path:
    """A file or folder of the reference data.

    It is not part of the repository: a user's machine skips the test, a CI machine must have it.
    """
    path = REFERENCE / name
    if not path.exists():
        sentence = f"the official reference data ({name}) is not on this machine"
        if os.environ.get("CI") == "true":
            pytest.fail(f"{sentence}, but CI=true asks for it")
        pytest.skip(sentence)
    return path
