"""Which browser speaks for a participant, so that a restart of the server sends nobody back to the start."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    op.add_column("identities", sa.Column("token", sa.String(length=64)))
    op.create_index(op.f("ix_identities_token"), "identities", ["token"])
