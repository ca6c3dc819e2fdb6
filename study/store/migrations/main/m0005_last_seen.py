"""When participants were last seen, so that an absence goes on over a stop of the server."""

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"


def upgrade() -> None:
    op.add_column("participants", sa.Column("last_seen_ms", sa.BigInteger()))
