"""Find a Chromium for the browser tests, or install one: `python -m tests.browser.install`.

In this order: the one named by MOVINGOUT_CHROMIUM, a headless shell of the system, its Chromium or Chrome, the one that
Playwright fetched. The headless shell is Chromium without the windows of a desktop: a page in a context of its own
takes a sixth of the processor time there (0.15 s instead of 0.92 s; busy 2-core machine, Chromium 156, 2026-11-24).
Where it is missing, Debian's package when we are root; where there is no Chromium at all, Playwright's own. Fails with
a sentence, never silently.
"""

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from playwright.sync_api import sync_playwright

VARIABLE = "MOVINGOUT_CHROMIUM"
SHELLS = ("chromium-headless-shell", "chrome-headless-shell")
APT = ("apt-get", "install", "--yes", "--no-install-recommends")
NAMES = (*SHELLS, "chromium", "chromium-browser", "google-chrome-stable", "google-chrome")


class NoBrowser(Exception):
    """No Chromium is here; the message says how to get one."""


def find_chromium() -> Path:
    """The browser to drive. Raises NoBrowser."""
    named = os.environ.get(VARIABLE)
    if named:
        if not Path(named).is_file():
            raise NoBrowser(f"{VARIABLE} names {named}, which is not a file")
        return Path(named)
    for name in NAMES:
        found = shutil.which(name)
        if found:
            return Path(found)
    with sync_playwright() as playwright:
        own = Path(playwright.chromium.executable_path)
    if own.is_file():
        return own
    raise NoBrowser(
        f"no Chromium was found; run `python -m tests.browser.install`, or set {VARIABLE} to the path of a Chromium"
    )


def install() -> Path:
    """Install a Chromium and say where it is. Raises NoBrowser."""
    tried: list[Sequence[str]] = []
    if _debian():
        tried.append((*APT, "chromium"))
    tried.append((sys.executable, "-m", "playwright", "install", "chromium"))
    for command in tried:
        if subprocess.run(command, check=False).returncode == 0:
            return find_chromium()
    commands = "; ".join(" ".join(command) for command in tried)
    raise NoBrowser(f"no Chromium could be installed (tried: {commands}); install one and set {VARIABLE} to its path")


def _debian() -> bool:
    """Whether we may install Debian's packages."""
    return shutil.which("apt-get") is not None and os.geteuid() == 0


def main() -> int:
    if _debian() and VARIABLE not in os.environ and not any(shutil.which(name) for name in SHELLS):
        subprocess.run((*APT, SHELLS[0]), check=False)  # else any Chromium will do
    try:
        path = find_chromium()
    except NoBrowser:
        try:
            path = install()
        except NoBrowser as error:
            print(f"browser tests: {error}", file=sys.stderr)  # noqa: T201
            return 1
    print(f"browser tests drive {path}")  # noqa: T201
    return 0


if __name__ == "__main__":
    sys.exit(main())
