"""A command that ends with the program that has started it, also when that one was killed.

Its standard input is a pipe from that program, which the system closes in any case.
"""

import os
import signal
import sys
import threading

from movingout.server.cli import main

PROGRAM = (sys.executable, "-P", "-m", "movingout.server.commands.with_parent")  # before the words of the command


def _end_with_parent() -> None:
    while os.read(0, 1):  # ends when the other end is closed
        pass
    os.kill(os.getpid(), signal.SIGTERM)


if __name__ == "__main__":
    threading.Thread(target=_end_with_parent, name="end-with-parent", daemon=True).start()
    sys.exit(main(sys.argv[1:]))
