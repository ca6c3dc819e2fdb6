from pathlib import Path

import pytest

from movingout.agents.partners.families import families
from movingout.maps import map_names
from movingout.matches import MatchError, read_grid
from movingout.matches.experiment.plan import matches_of, planned_matches
from movingout.matches.experiment.shipped_grids import grid_path, shipped_grids
from movingout.matches.paper.budgets import BUDGETS
from movingout.matches.paper.registry import chosen_entries
from movingout.matches.paper.steps import paper_steps
from movingout.matches.paper.workspace import Workspace
from movingout.server.cli import configured
from tests.matches.support import HERE, small_grid, written
from tests.support import ROOT


def test_a_grid_plays_everybody_with_everybody_on_every_map_once() -> None:
    plan = planned_matches(small_grid())
    pairs = {(entry.agent, entry.partner) for entry in plan}
    assert pairs == {(a, b) for a in (f"{HERE}:Wanderer", "idle") for b in (f"{HERE}:Wanderer", "idle")}
    assert len(plan) == 2 * 4 * 3
    assert len(matches_of(plan)) == len(set(matches_of(plan)))


def test_with_both_seats_the_agent_changes_seats_from_seed_to_seed() -> None:
    plan = [entry for entry in planned_matches(small_grid(partners=["scripted"])) if entry.agent == "idle"]
    assert {(entry.match.seed, entry.seat, entry.match.seats.index("idle")) for entry in plan} == {
        (0, 0, 0), (1, 1, 1), (2, 0, 0),
    }  # fmt: skip


def test_all_means_the_twelve_maps_and_two_challenges_double_the_work() -> None:
    plan = planned_matches(small_grid(maps="all", challenge=[1, 2], seeds={"first": 5, "count": 2}))
    assert {entry.match.map for entry in plan} == set(map_names())
    assert {(entry.match.challenge, entry.match.seed) for entry in plan} == {(1, 5), (1, 6), (2, 5), (2, 6)}


def test_people_of_a_population_take_turns_and_never_meet_themselves() -> None:
    plan = planned_matches(small_grid(agents=["people:C"], partners="self", seeds=30, maps=["HandOff"]))
    assert len({entry.match.blue for entry in plan}) == 20
    assert all(entry.match.blue != entry.match.red for entry in plan)


@pytest.mark.parametrize("members", [("people:C", 20), ("@list", 3), ("@list", 2)])
def test_with_both_seats_everybody_of_a_group_is_met_in_both(members: tuple[str, int], tmp_path: Path) -> None:
    name, size = members
    if name == "@list":
        (tmp_path / "list.txt").write_text("\n".join(f"scripted:seed={seed}" for seed in range(size)), encoding="utf-8")
        name = f"@{tmp_path / 'list.txt'}"
    grid = small_grid(agents=["idle"], partners=[name], seeds=2 * size, maps=["HandOff"])
    plan = planned_matches(grid)
    met = {(entry.match.seats[1 - entry.seat], entry.seat) for entry in plan}
    assert len(met) == len(plan) == 2 * size
    first = {entry.match.seats[1 - entry.seat] for entry in plan if entry.match.seed < size}
    assert len(first) == size, "as many seeds as there are members meet everybody"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name: x\nagents: [idle]\nmaps: [HandOf]\n", "line 3: maps: unknown map 'HandOf'; did you mean HandOff?"),
        ("name: x\nagents: [idle]\nseeds: -1\n", "line 3: seeds"),
        ("name: x\nagents: [idle]\n\nepisods: 4\n", "line 4: episods: there is no such field; "),
        ("name: x\n", "either 'agents' (and 'partners') or 'conditions'"),
        ("agents: [idle]\n", "name: this field is missing"),
        ("name: x\nagents: [idle, idle]\n", "the pair idle with idle is listed twice"),
        ("name: x\nagents: [idle]\npartners: [scripted, scripted]\n", "idle with scripted is listed twice"),
        ("name: x\nagents: [idle]\nchallenge: [1, 1]\n", "line 3: challenge: challenge 1 is listed twice"),
        ("name: x\nagents: [idle]\nmaps: []\n", "line 3: maps: name at least one map, or write all"),
        (
            "name: x\nagents: [idle]\nmaps: HandOff\n",
            "line 3: maps: a list is needed here; for one entry, write [HandOff]",
        ),
        (
            'name: x\nagents: [idle]\npartners: "@p.txt"\n',
            'line 3: partners: a list is needed here; for one entry, write ["@p.txt"]',
        ),
        ("name: x\nagents: idle\n", "line 2: agents: a list is needed here; for one entry, write [idle]"),
        ("name: x\nagents: [idle]\npartners: {a: 1}\n", "line 3: partners: a list is needed here"),
        ("- x\n", "the file should have lines like 'name: ...'"),
        ("name: x\nagents: ['people:Z']\n", "unknown population 'Z'; known: A, B, C"),
        ("name: x\nname: y\nagents: [idle]\n", "line 2: name: 'name' appears twice"),
        ("name: x\nagents: &a [idle]\npartners: *a\n", "line 3: the file: no aliases (*a)"),
        ("name: [x\n", "line 2: the file: this is not YAML"),
        ("", "the file"),
        ("name: x\nconditions:\n  - name: a\n    agents: [idle]\n    against: b\n", "condition 'a' is against 'b'"),
        ("name: x\nconditions:\n  - name: a\n    agents: [3]\n", "line 4: conditions[0].agents[0]"),
        ("name: x\nagents: [idle]\nticks: many\n", "line 3: ticks: input should be a valid integer"),
    ],
)
def test_a_faulty_grid_is_refused_with_line_and_place(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(MatchError) as caught:
        read_grid(written(tmp_path, text))
    assert message in str(caught.value)


def test_a_grid_in_another_encoding_is_told_so_with_its_line(tmp_path: Path) -> None:
    (tmp_path / "grid.yaml").write_bytes("name: x\nagents: [gr\xf6\xdfer]\n".encode("cp1252"))
    with pytest.raises(MatchError, match=r"grid\.yaml: line 2: the file: is not UTF-8 text; in the editor, save it"):
        read_grid(tmp_path / "grid.yaml")


def test_a_grid_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(MatchError, match=r"cannot read .*nothing\.yaml: No such file"):
        read_grid(tmp_path / "nothing.yaml")


def test_the_page_says_what_the_grid_of_families_leaves_out() -> None:
    page = (ROOT / "docs/matches.md").read_text(encoding="utf-8")
    row = next(line for line in page.splitlines() if line.startswith("| `families` | scripted"))
    grid = read_grid(grid_path(Path("families")))
    (condition,) = grid.all_conditions
    met = {partner.removeprefix("family:") for partner in condition.partners or ()}
    assert families().keys() - met == {"latent"} and "seven of the eight families of partners (without `latent`)" in row
    assert len(met) == 7 and len(families()) == 8
    trained = {one.agent for one in condition.contestants if "@" in one.agent}
    assert all(f"`{agent}`" in row.split("|")[3] for agent in trained)
    mirrored = {name.removesuffix(":mirror") for name in grid.maps if name.endswith(":mirror")}
    assert (
        mirrored == set(map_names())
        and "on the 12 maps, as they are and mirrored, and on 12 generated test maps" in row
    )


def test_beside_the_paper_bass_chooses_as_it_did_there() -> None:
    """Among four independent pairs; only the table of sampling schemes has others."""
    for name in (name for name in shipped_grids() if name != "sampling"):
        for condition in (one for one in read_grid(grid_path(Path(name))).all_conditions if one.paper):
            agents = [one.agent for one in condition.contestants if one.agent.startswith("bass")]
            for agent in agents:
                assert agent.endswith("score=nfd,sampling=4"), (name, agent)


@pytest.mark.parametrize("name", shipped_grids())
def test_what_a_shipped_grid_says_about_getting_its_agents_is_a_command(name: str) -> None:
    grid = read_grid(grid_path(Path(name)))
    agents = [one for condition in grid.all_conditions for one in condition.contestants if one.needs]
    for one in agents:
        command, _, models = one.needs.partition("; then ")
        words = command.split()
        if words == ["make", "agents"]:
            continue
        assert words[:3] == ["movingout", "paper", "tables"], name
        wanted = configured("paper")[1].parse_args(words[2:])
        assert models.split()[0] == f"MOVINGOUT_MODELS={wanted.out}/data/models", name
        (entry,) = chosen_entries(wanted.labels)
        space = Workspace(budget=BUDGETS["smoke"], evaluation=wanted.evaluation)
        trained = {step.about.split()[1] for step in paper_steps([entry], space) if step.about.startswith("train ")}
        assert one.agent.partition(":")[0] in trained, one.agent
