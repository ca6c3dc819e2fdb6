"""What tests of several folders share: where the reference data of the official environment lies,
and a loop for what is asynchronous.
"""

import asyncio
import os
from collections.abc import Coroutine
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, TypeVar

import pytest

Result = TypeVar("Result")

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


def run(scenario: Coroutine[Any, Any, Result]) -> Result:
    """What a coroutine returns; in a thread, since browser tests leave a running loop in the main one."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, scenario).result()
