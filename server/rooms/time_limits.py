"""How long a room waits for what, in seconds, and how much it takes of one player."""

PRACTICE_COUNTDOWN_S = 1.0
ANNOUNCE_S = 1.0  # between two announcements of a state that does not change
EARLY_S = 0.002  # a timer may fire this early
AGENT_PATIENCE_S = 10.0  # the countdown waits so long for an agent to load
AGENTS_WAIT_S = 60.0  # agents are released if no client comes for so long
SHOW_RESULT_S = 6.0  # between two rounds that agents play among themselves
EMPTY_S = 900.0  # a room without clients closes after this
INVITED_S = 300.0  # so does one where nobody has taken a seat yet, though it has a link for somebody
UNJOINED_S = 60.0  # so does one that waits for nobody but the page that opened it
CHANGES_PER_S = 4.0  # of one seat: ready, no longer ready, once more
CHANGES_BURST = 8.0
PAUSE_LIMIT_S = 600.0  # for players who paused while nobody waits for them
PAUSES = 3  # of one player in a round, while somebody else plays along
WAIT_LIMIT_S = 120.0  # for one player in a round, in all its pauses together, while somebody else is ready
RETURNS = 4.0  # the absences of one player in a round are together as long as so many that are waited for
DROP_S = 3.0  # what every lost connection counts at least: the countdown afterwards
HOLD_LIMIT_S = 24 * 3600.0  # for an experimenter who paused the room
RESTART_RESUME_S = 120.0  # for people to come back after the server was started again
