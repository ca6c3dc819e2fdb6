"""Who shares a screen, how long a page was hidden meanwhile, and whether the participants were programs."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    op.add_column("participants", sa.Column("screen", sa.String(length=16), nullable=False, server_default=""))
    op.add_column("study", sa.Column("simulated", sa.Boolean(), nullable=False, server_default=sa.false()))
    op.add_column("answers", sa.Column("hidden_ms", sa.Float(), nullable=False, server_default="0"))
