"""The partners of a study that has begun are timed while it is served: no participant waits for that."""

import logging
import threading

from movingout.maps import MovingOutError
from movingout.maps.files.terminal import printable_lines
from movingout.study.design.definition import Study
from movingout.study.design.partner_speed import slow_partners

log = logging.getLogger(__name__)

STANDS_STILL = "the study has begun and goes on: a partner that is too slow when its round begins stands still in it"
THREAD = "timing partners"


def tell_ready(links: str, study: Study, timed: bool) -> None:
    """Print the links of a server that is ready; where partners are `timed`, the log names slow ones later."""
    print(printable_lines(links), flush=True)  # with the title of the study, whose file may be somebody else's
    if timed:
        threading.Thread(target=_warn_of_slow, args=(study,), name=THREAD, daemon=True).start()


def _warn_of_slow(study: Study) -> None:
    try:
        slow = slow_partners(study, progress=False)
    except (MovingOutError, OSError) as error:
        log.warning("the partners could not be timed: %s", error)
        return
    for sentence in (*slow, *([STANDS_STILL] if slow else [])):
        log.warning("%s", sentence)
