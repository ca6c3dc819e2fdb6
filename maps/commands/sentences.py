"""What a command says beside its answer."""

import sys

from movingout.maps.files.terminal import printable_lines


def tell(sentence: str) -> None:
    """Print `movingout: sentence` to standard error, of names and texts that others chose only what can be printed."""
    print(f"movingout: {printable_lines(sentence)}", file=sys.stderr)
