"""Who shares a screen, and how long the page was hidden while an answer was thought about."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    op.add_column("participants", sa.Column("screen", sa.String(length=16), nullable=False, server_default=""))
    op.add_column("answers", sa.Column("hidden_ms", sa.Float(), nullable=False, server_default="0"))
