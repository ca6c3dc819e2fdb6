"""The tables of a study. Times are milliseconds of the wall clock since the epoch; participants are pseudonyms.

`audit` only ever grows (the database itself refuses changes), and names participants by a hash, so that deleting a
participant leaves nothing to remove there.
"""

from typing import Any

from sqlalchemy import (
    BigInteger,
    Boolean,
    Column,
    Float,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    String,
    Table,
    Text,
    UniqueConstraint,
    false,
    text,
)

from movingout.world.constants import TICK_MS
from movingout.world.metrics import METRICS

metadata = MetaData(
    naming_convention={
        "pk": "pk_%(table_name)s",
        "fk": "fk_%(table_name)s_%(column_0_name)s",
        "uq": "uq_%(table_name)s_%(column_0_name)s",
        "ix": "ix_%(column_0_label)s",
    }
)
identity_metadata = MetaData(naming_convention=metadata.naming_convention)

_INSIDE = {"exported": False}  # of columns that no export holds


def exported(table: Table) -> list[Column[Any]]:
    """The columns that may leave the database."""
    return [column for column in table.columns if column.info.get("exported", True)]


study = Table(
    "study",
    metadata,
    Column("id", String(48), primary_key=True, doc="id of the study"),
    Column("frozen_ms", BigInteger, nullable=False, doc="when the study was frozen"),
    Column("file_text", Text, nullable=False, doc="study.yaml as it was then"),
    Column("file_sha256", String(64), nullable=False, doc="its SHA-256"),
    Column("code", Text, nullable=False, doc="versions of the software that it was served with last, JSON"),
    Column(
        "models",
        Text,
        nullable=False,
        doc="agent id to SHA-256 of its checkpoint, map:NAME to that of an own map, JSON",
    ),
    Column("simulated", Boolean, nullable=False, server_default=false(), doc="whether the participants were programs"),
    Column("allocation", Integer, nullable=False, server_default="1", info=_INSIDE, doc="rule that draws the slots"),
    Column("salt", String(32), nullable=False, info=_INSIDE, doc="of the hashes in the audit; leads to who left"),
    Column("paused", Boolean, nullable=False, server_default=false(), info=_INSIDE, doc="by the experimenter, for all"),
)
units = Table(
    "units",
    metadata,
    Column("id", Integer, primary_key=True, doc="number of the unit: one participant, or a pair"),
    Column("slot", Integer, nullable=False, doc="slot of the allocation, from 0"),
    Column(
        "state",
        String(8),
        nullable=False,
        doc="active, done, purged (done, its time over) or dropped; a dropped slot is given again",
    ),
    Column("formed_ms", BigInteger, nullable=False, doc="when it began"),
    Column("paused", Boolean, nullable=False, server_default=false(), info=_INSIDE, doc="by the experimenter"),
)
Index(
    "uq_units_held_slot",
    units.c.slot,
    unique=True,
    sqlite_where=text("state != 'dropped'"),
    postgresql_where=text("state != 'dropped'"),
)
participants = Table(
    "participants",
    metadata,
    Column("pid", String(16), primary_key=True, doc="pseudonym"),
    Column("unit", ForeignKey("units.id"), index=True, doc="the unit, empty until it is formed"),
    Column("member", Integer, nullable=False, doc="0, or 1 for the second of a pair"),
    Column("language", String(8), nullable=False, doc="of the screens"),
    Column("step", Text, nullable=False, doc="key of the step that the participant is at"),
    Column("arrived_ms", BigInteger, nullable=False, doc="first seen"),
    Column("finished_ms", BigInteger, doc="when the code was given; of who was away then, when they were last there"),
    Column(
        "outcome",
        String(16),
        doc="done, partner-left, no-partner, withdrew (pressed Stop; with an empty `keep` the experimenter ended it), "
        "dropped-out (did not come back; data of earlier versions say withdrew or, of the waiting room, no-partner) "
        "or screened-out",
    ),
    Column("code", String(40), info=_INSIDE, doc="completion code; leads to who was paid"),
    Column("keep", Boolean, doc="whether the data may be kept, asked at the debrief or at Stop"),
    Column("screen", String(16), nullable=False, server_default="", doc="the same for two who share one screen"),
    Column("away_ms", BigInteger, nullable=False, server_default="0", info=_INSIDE, doc="absences; they are not paid"),
    Column(
        "last_seen_ms",
        BigInteger,
        info=_INSIDE,
        doc="noted once a minute, without their absence, which a pause ends; a server that starts goes on from there",
    ),
    Column("heard_ms", BigInteger, info=_INSIDE, doc="when a page of theirs was last heard, noted once a minute"),
)
consents = Table(
    "consents",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("pid", ForeignKey("participants.pid"), nullable=False, index=True, doc="participant"),
    Column("version", String(40), nullable=False, doc="version of the consent"),
    Column("language", String(8), nullable=False, doc="language of the shown text"),
    Column("sha256", String(64), nullable=False, doc="of the shown text"),
    Column("boxes", Text, nullable=False, doc="ids of the ticked boxes, JSON"),
    Column("given_ms", BigInteger, nullable=False, doc="when it was given"),
)
rounds = Table(
    "rounds",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("unit", ForeignKey("units.id"), nullable=False, doc="who played"),
    Column("step", Text, nullable=False, doc="key of the step"),
    Column(
        "attempt",
        Integer,
        nullable=False,
        doc="from 1; higher where the round was played again, after the experimenter restarted it or a crash ended it. "
        "Every attempt is a row, so there may be more rows than planned rounds; `outcome` says how each ended",
    ),
    Column("block", String(48), nullable=False, doc="block of the study"),
    Column(
        "partner",
        String(48),
        nullable=False,
        doc="id of the partner; in pairs empty, or `agent` where one took the place of a partner",
    ),
    Column(
        "map",
        Text,
        nullable=False,
        doc="as study.yaml names it; recordings of a map file, and what is made of them, have the name in the file: "
        "`map_name`",
    ),
    Column("variant_seed", BigInteger, doc="of a randomised map, empty for the map as designed"),
    Column(
        "position",
        Integer,
        nullable=False,
        doc="which round of the unit this is, from 1, with those that were repeated",
    ),
    Column("limit_ticks", Integer, nullable=False, doc=f"time limit, ticks of {TICK_MS} ms"),
    Column(
        "episode",
        String(64),
        nullable=False,
        unique=True,
        doc="id of the recording; begins with unplayed- where there is none",
    ),
    Column(
        "started_ms", BigInteger, nullable=False, doc="when the room for it was opened, seconds before the first tick"
    ),
    Column("ended_ms", BigInteger, doc="last tick, empty while it runs"),
    Column("outcome", String(16), doc="delivered, time, left, stopped, error or interrupted"),
    Column("ticks", Integer, doc="ticks played"),
    *(Column(metric.key, Float, doc=metric.documentation) for metric in METRICS if metric.from_paper),
    Column("late_ms", Float, doc="99th percentile of the lateness of ticks, ms"),
    Column(
        "valid",
        Boolean,
        nullable=False,
        doc="false where the experimenter marked it invalid or, with error and no tick, its map could not be varied",
    ),
    UniqueConstraint("unit", "step", "attempt"),
)
players = Table(
    "players",
    metadata,
    Column("round", ForeignKey("rounds.id"), primary_key=True, doc="round"),
    Column("pid", ForeignKey("participants.pid"), primary_key=True, index=True, doc="participant"),
    Column("seat", Integer, nullable=False, doc="0 blue, 1 red"),
    Column("device", String(16), nullable=False, doc="keyboard, gamepad or touch; empty: unknown"),
    Column("rtt_ms", Float, doc="median round trip, ms"),
    Column("idle_share", Float, doc="share of ticks without any input, 0 to 1"),
    Column("hidden_s", Float, doc="seconds that the page was hidden"),
)
answers = Table(
    "answers",
    metadata,
    Column("id", Integer, primary_key=True, doc="grows with time; the newest answer to an item counts"),
    Column("pid", ForeignKey("participants.pid"), nullable=False, index=True, doc="participant"),
    Column(
        "step",
        Text,
        nullable=False,
        doc="key of the step; of questions after a round that of the round, a slash and `questionnaire`",
    ),
    Column("questionnaire", String(48), nullable=False, doc="questionnaire"),
    Column("partner", String(48), nullable=False, doc="whom it is about, as in rounds, empty for nobody"),
    Column("item", String(40), nullable=False, doc="question"),
    Column("value", Integer, nullable=False, doc="on the item's scale; -1 for no answer and for free text"),
    Column("text", Text, nullable=False, doc="free text"),
    Column("elapsed_ms", Float, nullable=False, doc="since the page was shown"),
    Column(
        "at_ms", BigInteger, nullable=False, doc="when it was stored: later than the click where the page was offline"
    ),
    Column("hidden_ms", Float, nullable=False, server_default="0", doc="of elapsed_ms, how long the page was hidden"),
)
notes = Table(
    "notes",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("unit", ForeignKey("units.id"), doc="about whom, empty for the study"),
    Column("text", Text, nullable=False, doc="what the experimenter wrote"),
    Column("at_ms", BigInteger, nullable=False, doc="when"),
)
counts = Table(
    "counts",
    metadata,
    Column("name", String(16), primary_key=True, doc="what is counted: declined"),
    Column("number", Integer, nullable=False, doc="how many; nothing else is kept of those who declined"),
)
audit = Table(
    "audit",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("at_ms", BigInteger, nullable=False, doc="when"),
    Column("actor", String(16), nullable=False, doc="participant, experimenter or server"),
    Column("action", String(32), nullable=False, doc="what"),
    Column("subject", String(16), nullable=False, doc="hash that stands for the participant, or empty"),
    Column("detail", Text, nullable=False, doc="JSON"),
)
tombstones = Table(
    "tombstones",
    metadata,
    Column("subject", String(16), primary_key=True, doc="hash that stood for the participant"),
    Column("at_ms", BigInteger, nullable=False, doc="when"),
    Column("rows", Integer, nullable=False, doc="rows removed"),
    Column("recordings", Integer, nullable=False, doc="recordings removed"),
)
identities = Table(
    "identities",
    identity_metadata,
    Column("pid", String(16), primary_key=True, doc="pseudonym"),
    Column("source", String(16), nullable=False, doc="prolific, mturk, code or link"),
    Column("external_id", Text, nullable=False, doc="id there"),
    Column("parameters", Text, nullable=False, doc="other parameters of the recruitment, JSON"),
    Column("at_ms", BigInteger, nullable=False, doc="first seen"),
    Column("token", String(64), index=True, doc="hash of the secret of the browser that was opened last"),
    UniqueConstraint("source", "external_id"),
)
