"""The program that docs/metrics.md shows must run."""

import pytest

from tests.support import ROOT

pytest.importorskip("pettingzoo", reason="the extra `env` is not installed")


@pytest.mark.slow
def test_the_documented_training_loop_runs_to_the_end(capsys: pytest.CaptureFixture[str]) -> None:
    text = (ROOT / "docs" / "metrics.md").read_text(encoding="utf-8")
    program = text.split("```python")[1].split("```")[0]
    exec(compile(program.replace("limit_ticks=500", "limit_ticks=20"), "docs/metrics.md", "exec"), {})
    assert "'tcr': 0.0" in capsys.readouterr().out
