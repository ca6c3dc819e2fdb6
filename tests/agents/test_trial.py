"""Which agents are tried before a study begins: those whose code is not ours."""

import pytest

from movingout.agents.trial import runs_own_code

OWN = ("my_agent:Mine", "late:agent=my_agent:Mine", "onnx:path=policy.onnx", "movingout_extra:Mine")
OURS = ("scripted", "dp@all:lag=1", "person:name=C03", "movingout.agents.scripted.patient_partner:PatientPartner")


@pytest.mark.parametrize("agent_id", [*OWN, *OURS])
def test_agents_of_this_package_are_nobodys_own(agent_id: str) -> None:
    assert runs_own_code(agent_id) == (agent_id in OWN)
