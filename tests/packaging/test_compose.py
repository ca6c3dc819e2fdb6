"""The container finds a study with all that lies beside its file."""

import re
from pathlib import PurePosixPath
from typing import Any

import pytest
import yaml

from tests.support import ROOT

COMPOSE = (ROOT / "deploy/compose.yaml").read_text(encoding="utf-8")


def server(**environment: str) -> dict[str, Any]:
    """The service of the study, as compose reads the file with these variables and the defaults of others."""
    text = re.sub(r"\$\{(\w+)(?::[-?]([^}]*))?\}", lambda found: environment.get(found[1], found[2] or ""), COMPOSE)
    service: dict[str, Any] = yaml.safe_load(text)["services"]["server"]
    return service


@pytest.mark.parametrize(
    ("environment", "folder", "file"),
    [({}, ".", "study.yaml"), ({"STUDY_FOLDER": "/srv/pilot", "STUDY": "pilot.yaml"}, "/srv/pilot", "pilot.yaml")],
)
def test_the_folder_of_the_study_is_mounted_with_its_texts_and_maps(
    environment: dict[str, str], folder: str, file: str
) -> None:
    service = server(**environment)
    served = PurePosixPath(service["command"][service["command"].index("serve") + 1])
    mounted = [volume.split(":") for volume in service["volumes"]]
    assert served.name == file
    assert [folder, str(served.parent), "ro"] in mounted
