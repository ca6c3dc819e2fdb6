"""When participants were last heard themselves, which no pause of the experimenter moves: retention begins there."""

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"


def upgrade() -> None:
    op.add_column("participants", sa.Column("heard_ms", sa.BigInteger()))
    op.execute("UPDATE participants SET heard_ms = last_seen_ms")  # the best that is known of before
