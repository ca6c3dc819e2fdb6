"""For how long participants were away before they came back, which is not paid."""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"


def upgrade() -> None:
    op.add_column("participants", sa.Column("away_ms", sa.BigInteger(), nullable=False, server_default="0"))
