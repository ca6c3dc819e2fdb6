"""What the experimenter has paused. That a payment was noted is gone: nothing ever did, platforms and banks know."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    op.add_column("study", sa.Column("paused", sa.Boolean(), nullable=False, server_default=sa.false()))
    op.add_column("units", sa.Column("paused", sa.Boolean(), nullable=False, server_default=sa.false()))
    op.drop_column("participants", "paid_ms")
