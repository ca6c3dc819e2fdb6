"""`python -m movingout` is the command `movingout`."""

import sys

from movingout.server.cli import main

if __name__ == "__main__":
    sys.exit(main())
