"""The configuration that `movingout cluster config` writes."""

import os
import subprocess
from pathlib import Path
from typing import Any

import pytest

from movingout.server.cli import main
from movingout.server.cluster.errors import ClusterError
from movingout.server.cluster.proxy_config import ProxyConfig, ProxyLimits, nodes_of
from tests.server.cluster.processes import proxy_program

NODES = ("--node", "a=10.0.0.1:8000", "--node", "b=[fd00::2]:8000")


def written(capsys: pytest.CaptureFixture[str], *options: str) -> str:
    assert main(["cluster", "config", *NODES, *options]) == 0
    return capsys.readouterr().out


def test_haproxy_has_a_group_of_servers_per_shard(capsys: pytest.CaptureFixture[str]) -> None:
    text = written(capsys, "--domain", "game.example.org", "--certificate", "/etc/game.pem")
    assert text.count("\nbackend shard_") == 33
    assert "use_backend shard_study if { path_beg /api/study /api/experimenter }" in text
    assert "bind :443 ssl crt /etc/game.pem alpn h2,http/1.1" in text and "redirect scheme https" in text
    assert "bind :::443 v6only ssl crt /etc/game.pem alpn h2,http/1.1\n    bind :80\n    bind :::80 v6only\n" in text
    assert "deny_status 421 unless { req.hdr(host),field(1,:) -i game.example.org }" in text
    assert "track-sc0 src,ipmask(32,64)" in text
    shard = text.split("backend shard_k\n")[1].split("backend")[0]
    assert "uri /cluster/rooms/k " in shard
    assert "server a 10.0.0.1:8000 check" in shard and "server any-b [fd00::2]:8000 track pages/b backup" in shard


def test_a_large_class_behind_one_address_may_send_more(capsys: pytest.CaptureFixture[str]) -> None:
    usual, more = written(capsys), written(capsys, "--max-per-address", "2000")
    for rate, one, other in (
        ("sc0_conn_cur(addresses)", 400, 2000),
        ("sc0_conn_rate(addresses)", 1000, 5000),
        ("sc1_http_req_rate(requests)", 2400, 12000),
        ("sc0_http_req_rate(addresses)", 9600, 48000),
    ):
        assert f"{rate} gt {one} }}" in usual and f"{rate} gt {other} }}" in more
    assert "sc0_conn_rate(addresses) gt 1000 }" in written(capsys, "--max-per-address", "20")


def test_an_operator_is_told_of_the_same_node_again_and_again(capsys: pytest.CaptureFixture[str]) -> None:
    text = written(capsys)
    rules = [line.split()[1] for line in text.splitlines() if line.startswith("    use_backend")]
    assert rules == ["shard_study", "shard_%[var(txn.shard)]", "operator", "lobby"], "rooms go to their node first"
    assert "backend operator\n    balance source\n    hash-type consistent\n    server a 10.0.0.1:8000 track" in text
    caddy = written(capsys, "--for", "caddy")
    assert "lb_policy ip_hash" in caddy.split("handle /api/admin/* {")[1].split("handle")[0]


POD = ("--node", "c=movingout-0.movingout.invalid:8001")


def test_haproxy_looks_for_names_again_where_nodes_get_other_addresses(capsys: pytest.CaptureFixture[str]) -> None:
    text = written(capsys, *POD, "--resolve-names")
    assert "resolvers system\n    parse-resolv-conf\n" in text
    assert "    default-server init-addr last,libc,none resolvers system " in text
    assert "resolvers" not in written(capsys, *POD)


@pytest.mark.slow  # where no name server answers
def test_haproxy_starts_while_a_pod_has_no_address(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "haproxy.cfg"
    file.write_text(written(capsys, *POD, "--resolve-names"))
    impatient = {**os.environ, "RES_OPTIONS": "timeout:1 attempts:1"}
    program = [proxy_program("haproxy"), "-c", "-f", str(file)]
    checked = subprocess.run(program, capture_output=True, text=True, env=impatient)
    assert checked.returncode == 0, checked.stderr


def test_without_a_certificate_it_is_plain_http(capsys: pytest.CaptureFixture[str]) -> None:
    text = written(capsys)
    assert "bind :80\n    bind :::80 v6only\n" in text and "redirect scheme" not in text and "ssl crt" not in text


def test_caddy_has_the_same_routing(capsys: pytest.CaptureFixture[str]) -> None:
    text = written(capsys, "--for", "caddy", "--domain", "game.example.org")
    assert text.count("health_uri /cluster/rooms/") == 33 and text.count("{") == text.count("}")
    assert "path_regexp ^/(ws|api/rooms|api/recordings|api/admin/rooms)/k[^/]*" in text
    assert "\ngame.example.org {\n" in text and "\ttls " not in text
    assert text.index("\n{\n\tlog {\n\t\texclude http.log.error\n") < text.index("game.example.org {\n"), (
        "options are first"
    )
    own = written(capsys, "--for", "caddy", "--domain", "game.example.org", "--certificate", "/etc/game.pem")
    assert "\ngame.example.org {\n\ttls /etc/game.pem /etc/game.pem\n" in own


def test_the_file_says_how_it_was_made_and_where_it_lies(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "haproxy.cfg"
    assert main(["cluster", "config", *NODES, "-o", str(file)]) == 0
    assert "for 2 nodes" in capsys.readouterr().err and file.read_text().startswith("# HAProxy in front of the nodes")
    assert main(["cluster", "config", *NODES, "-o", str(tmp_path / "none" / "x")]) == 2


@pytest.mark.parametrize("wrong", ["a", "a=10.0.0.1", "a=10.0.0.1:99999", "a b=10.0.0.1:80", "=10.0.0.1:80", "a=h\n:1"])
def test_what_is_no_node_is_said(wrong: str) -> None:
    with pytest.raises(ClusterError, match=r"it looks like a=10\.0\.0\.1:8000"):
        nodes_of([wrong])


def test_nodes_have_names_and_addresses_of_their_own_and_nothing_is_smuggled_in() -> None:
    with pytest.raises(ClusterError, match="of its own"):
        nodes_of(["a=h:1", "a=h:2"])
    with pytest.raises(ClusterError, match="of its own"):
        nodes_of(["a=h:1", "b=h:1"])
    smuggled = "x\n    bind :1"
    with pytest.raises(ClusterError, match="special characters"):
        ProxyConfig({"a": "h:1"}, certificate=smuggled)
    with pytest.raises(ClusterError, match="special characters"):
        ProxyConfig({"a": "h:1"}, listen=smuggled)
    with pytest.raises(ClusterError, match="special characters"):
        ProxyConfig({"a": "h:1"}, admin_socket=smuggled)
    with pytest.raises(ClusterError, match=r"game\.example\.org"):
        ProxyConfig({"a": "h:1"}, domain="a b")
    with pytest.raises(ClusterError, match="at least one node"):
        ProxyConfig({})
    with pytest.raises(ClusterError, match="up to 32 nodes, not 33; make two clusters"):
        ProxyConfig({f"n{number}": f"h:{number}" for number in range(1, 34)})


@pytest.mark.parametrize("wrong", ["rubbish", "443", ":99999", ":0", "10.0.0.9", "[::1", "ftp://a:1", "a:b:1"])
def test_a_proxy_that_could_listen_nowhere_is_refused(wrong: str) -> None:
    with pytest.raises(ClusterError, match="is nowhere to listen; it looks like :443"):
        ProxyConfig({"a": "h:1"}, listen=wrong)
    with pytest.raises(ClusterError, match="is nowhere to listen; it looks like :443"):
        ProxyConfig({"a": "h:1"}, redirect_from=wrong)


@pytest.mark.parametrize(
    ("listen", "bound"),
    [
        ("", [":80", ":::80 v6only"]),
        (":443", [":443", ":::443 v6only"]),  # HAProxy takes the first for IPv4 alone
        ("*:443", ["*:443"]),
        ("0.0.0.0:443", ["0.0.0.0:443"]),
        ("10.0.0.9:443", ["10.0.0.9:443"]),
        ("[::]:443", ["[::]:443"]),
    ],
)
def test_a_proxy_listens_at_an_address_and_a_port(listen: str, bound: list[str]) -> None:
    text = ProxyConfig({"a": "h:1"}, listen=listen).text("haproxy")
    assert [line.partition("bind ")[2] for line in text.splitlines() if line.startswith("    bind ")] == bound
    own = f"http://{listen or ':80'}"
    assert f"\n{own} {{" in ProxyConfig({"a": "h:1"}, listen=own).text("caddy")
    with pytest.raises(ClusterError, match="without http://"):
        ProxyConfig({"a": "h:1"}, listen=own).text("haproxy")


def test_http_is_sent_to_the_port_of_https() -> None:
    def redirects(listen: str, redirect_from: str) -> list[str]:
        text = ProxyConfig({"a": "h:1"}, certificate="x.pem", listen=listen, redirect_from=redirect_from).text(
            "haproxy"
        )
        return [
            line.strip().removeprefix("http-request redirect ") for line in text.splitlines() if " redirect " in line
        ]

    usual, to = "scheme https code 301 unless { ssl_fc }", "location https://%[req.hdr(host),field(1,:)]"
    port, named = ":8443%[pathq] code 301 if !{ ssl_fc }", " { req.hdr(host) -m reg :[0-9]+$ }"
    assert redirects("", ":80") == redirects("10.0.0.9:443", "10.0.0.9:80") == [usual]
    assert redirects(":8443", ":80") == [to + port]
    assert redirects(":8443", ":8080") == [to + port + named, usual]
    assert redirects(":443", ":8080") == [to + port.removeprefix(":8443") + named, usual]
    assert redirects("", "") == []


@pytest.mark.parametrize(
    "options",
    [{"redirect_from": ":8080"}, {"admin_socket": "/run/x"}, {"limits": ProxyLimits.for_address(20_000, 500)}],
)
def test_what_would_do_nothing_is_refused(options: dict[str, Any]) -> None:
    with pytest.raises(ClusterError, match="are for HAProxy"):
        ProxyConfig({"a": "h:1"}, domain="game.example.org", **options).text("caddy")
    if "redirect_from" in options:
        with pytest.raises(ClusterError, match="needs --certificate"):
            ProxyConfig({"a": "h:1"}, **options).text("haproxy")
    else:
        assert ProxyConfig({"a": "h:1"}, **options).text("haproxy")


def test_caddy_listens_for_a_domain_at_another_port() -> None:
    config = ProxyConfig({"a": "h:1"}, domain="game.example.org", listen=":8443")
    assert "\ngame.example.org:8443 {" in config.text("caddy")
    with pytest.raises(ClusterError, match=r"Caddy takes a port alone, such as --listen :8443, not 10\.0\.0\.9:443"):
        ProxyConfig({"a": "h:1"}, domain="game.example.org", listen="10.0.0.9:443").text("caddy")
