"""Shards: the rooms, episodes and journals whose ids begin with the same letter. One node at a time has a shard."""

from movingout.server.security.tokens import ID_LETTERS, new_id

SHARDS = ID_LETTERS
STUDY = "study"  # the lease of the node that runs the study; not a letter, so that no room is in it


def shard_of(name: str) -> str:
    """The shard of a room, an episode or the file of one; empty for what is none of these."""
    letter = name[:1]
    return letter if letter in SHARDS else ""


def new_id_in(shard: str) -> str:
    """A new id of a room of this shard."""
    return shard + new_id()[1:]


def lease_title(shard: str) -> str:
    """What to call a lease in a sentence."""
    return "the study" if shard == STUDY else f"the shard {shard!r}"
