"""What the limits of an address ask of the other nodes of a cluster."""

from typing import NamedTuple


class RoomCount(NamedTuple):
    """Rooms of one address: all that are open, and those of them that nobody has joined."""

    open: int = 0
    unjoined: int = 0


class OtherNodes:
    """Those of a server that is no node: there are none, and what happens here decides.

    Rooms belong to owners (`admission.owner`), wrong tokens to groups of addresses (`admission.address_group`).
    """

    async def may_record(self, owner: str) -> bool:
        """Whether rooms of the address may fill the disks of all nodes further today."""
        return True

    async def may_open_room(self, owner: str) -> RoomCount | None:
        """How many rooms the address has at other nodes; None when it has opened too many of late."""
        return RoomCount()

    async def may_guess(self, group: str, secret: str) -> bool:
        """Count a wrong token of this kind; False when there were too many."""
        return True

    def recorded(self, owner: str, size: int) -> None:
        """Rooms of the address have recorded so many bytes here."""
