"""Where a study keeps what happens: one database for the data, another for who the participants are."""

from movingout.maps.extras import needs_extra

with needs_extra("study", "a study"):
    from movingout.study.store.identity import IdentityStore
    from movingout.study.store.store import Store, Unit

__all__ = ["IdentityStore", "Store", "Unit"]
