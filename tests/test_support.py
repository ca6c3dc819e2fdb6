"""Tests of data that lie beside the repository say that they are missing, as skipped or as failed."""

import pytest

from tests import support


@pytest.mark.parametrize(("value", "outcome"), [("", pytest.skip.Exception), ("required", pytest.fail.Exception)])
def test_only_a_variable_of_its_own_asks_for_the_reference_data(
    value: str, outcome: type[BaseException], monkeypatch: pytest.MonkeyPatch
) -> None:
    """GitHub sets CI=true and has no such folder: its workflow failed always."""
    monkeypatch.setenv("CI", "true")
    monkeypatch.setenv(support.REQUIRED, value)
    with pytest.raises(outcome, match=r"the official reference data \(no-such-file\) is not on this machine"):
        support.reference("no-such-file")
