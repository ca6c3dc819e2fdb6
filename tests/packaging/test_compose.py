"""The container finds a study with all that lies beside its file, and says when it is not well."""

import re
import subprocess
import sys
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer
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


def test_the_server_starts_anew_with_the_proxy_whose_network_namespace_it_shares() -> None:
    service = server()
    proxy = service["network_mode"].removeprefix("service:")
    assert service["depends_on"][proxy]["restart"] is True


@pytest.mark.parametrize(("status", "code"), [(200, 0), (503, 1)])
def test_a_server_that_is_not_well_is_called_unhealthy(status: int, code: int) -> None:
    asked = []

    class Health(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            asked.append(self.path)
            self.send_response(status)
            self.end_headers()

        def log_message(self, *_: object) -> None: ...

    kind, program, *words = server()["healthcheck"]["test"]
    assert (kind, program) == ("CMD", "python")
    with HTTPServer(("127.0.0.1", 0), Health) as health:
        threading.Thread(target=health.handle_request).start()
        here = [word.replace(":8000/", f":{health.server_port}/") for word in words]
        assert subprocess.run([sys.executable, *here], capture_output=True).returncode == code
    assert asked == ["/healthz"]
