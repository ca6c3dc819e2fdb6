"""Who may take part in a study, as whoever serves it says."""

from typing import NamedTuple


class Admission(NamedTuple):
    """What people need to be let in, and whether they are people."""

    needs_code: bool = False
    needs_signature: bool = False
    any_device: bool = False  # whether a platform's link leads back to its place in any browser
    simulated: bool = False  # participants are programs
