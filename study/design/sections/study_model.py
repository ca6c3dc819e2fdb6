"""What every section of a study file is: strict, and as it was read."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict

from movingout.study.design.localized_text import shaped

Name = Annotated[str, shaped(r"[a-z0-9][a-z0-9-]{0,47}", "small letters, digits and hyphens, at most 48")]


class StudyModel(BaseModel):
    """Unknown fields are errors, and values never change after reading."""

    model_config = ConfigDict(extra="forbid", frozen=True)
