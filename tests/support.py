"""What tests of several folders share: where the reference data of the official environment and the paper lie."""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
SHARED = ROOT.parent / "shared"
REFERENCE = SHARED / "reference"
REQUIRED = "MOVINGOUT_REFERENCE"  # the variable that asks for it, with the value `required`


def reference(name: str) -> Path:
    """A file or folder of the reference data."""
    return shared(f"reference/{name}", f"the official reference data ({name})")


def shared(name: str, what: str) -> Path:
    """A file or folder that lies beside the repository and is no part of it.

    Where it is missing the test is skipped, and fails where MOVINGOUT_REFERENCE=required.
    """
    path = SHARED / name
    if not path.exists():
        sentence = f"{what} is not on this machine"
        if os.environ.get(REQUIRED) == "required":
            pytest.fail(f"{sentence}, but {REQUIRED}=required asks for it")
        pytest.skip(sentence)
    return path
