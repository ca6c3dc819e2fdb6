"""`movingout demos people`: lists the scripted people and the families of partners."""

import argparse
import json
from collections.abc import Iterator

from movingout.agents.errors import AgentError
from movingout.agents.partners.families import Family, families, family_of, installed_families
from movingout.agents.scripted.populations import POPULATIONS, manifest, population
from movingout.maps.commands.sentences import tell
from movingout.maps.files.terminal import printable, printable_lines


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.set_defaults(perform=perform)


def perform(args: argparse.Namespace) -> int:
    """Print who there is; a family that cannot be loaded is left out with a sentence."""
    if args.json:
        print(json.dumps({**manifest(), "families": _families()}))
        return 0
    print("name  habits        as an agent")
    for name in POPULATIONS:
        for person in population(name):
            print(f"{person.name:4}  {person.sha256[:12]}  {person.agent_id}")
    for family in _all_families():
        print(
            printable_lines(f"\nfamily:{family.name}: {family.about}{'' if family.trains else '; for measuring only'}")
        )
        if not family.members:
            print(f"(none is trained here: {family.ids[0]}, …; see docs/learning.md)")
        for partner in family.members:
            print(printable(f"{partner.name}  {partner.agent_id}"))
    return 0


def _families() -> dict[str, object]:
    """The families for `demos people --json`."""
    return {
        family.name: {
            "about": family.about,
            "trains": family.trains,
            "members": [{"name": partner.name, "id": partner.agent_id} for partner in family.members],
        }
        for family in _all_families()
    }


def _all_families() -> Iterator[Family]:
    """Ours, then those of installed packages; a sentence about one that cannot be loaded."""
    yield from families().values()
    for name in installed_families():
        try:
            yield family_of(name)
        except AgentError as error:
            tell(f"left out: {error}")
