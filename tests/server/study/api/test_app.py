"""The pages of a served study."""

import urllib.request

import pytest

from tests.server.live import WAIT_S
from tests.server.study.support import Served


@pytest.mark.parametrize(
    ("path", "policy"), [("/study?id=Ann&sig=x", "strict-origin"), ("/experimenter", "same-origin")]
)
def test_requests_of_a_participants_page_do_not_name_its_address_which_says_who_it_is(
    solo: Served, path: str, policy: str
) -> None:
    with urllib.request.urlopen(f"http://{solo.live.address}{path}", timeout=WAIT_S) as page:
        assert page.headers.get_all("referrer-policy") == [policy]
