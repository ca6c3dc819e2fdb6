"""The rule by which the slots of a study are drawn: what began earlier keeps the first one."""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"


def upgrade() -> None:
    op.add_column("study", sa.Column("allocation", sa.Integer(), nullable=False, server_default="1"))
