"""Who asks for much waits for itself; whoever stops waiting is passed over."""

import asyncio

from movingout.server.connection.turns import Turns


async def asks(turns: Turns, who: str, done: list[str]) -> None:
    async with turns.turn(who):
        done.append(who)
        await asyncio.sleep(0)


def test_addresses_take_turns_each_in_its_order() -> None:
    async def work() -> list[str]:
        turns, done = Turns(), list[str]()
        await asyncio.gather(*(asks(turns, who, done) for who in "aaaabab"), asks(turns, "c", done))
        await asks(turns, "d", done)
        return done

    assert "".join(asyncio.run(work())) == "aabcabaa" + "d"


def test_who_has_asked_for_too_much_has_no_place_and_who_has_not_has_one() -> None:
    async def work() -> None:
        turns, done = Turns(), list[str]()
        asked = [asyncio.create_task(asks(turns, "a", done)) for _ in range(3)]
        await asyncio.sleep(0)
        assert not turns.has_place("a", most=8, most_of_one=3) and turns.has_place("b", most=8, most_of_one=3)
        assert not turns.has_place("a", most=3, most_of_one=8) and turns.has_place("b", most=3, most_of_one=8)
        assert not turns.has_place("b", most=1, most_of_one=8), "others have places of their own, too, but not endless"
        await asyncio.gather(*asked)
        assert turns.has_place("a", most=8, most_of_one=1)

    asyncio.run(work())


def test_who_stops_waiting_is_passed_over_also_when_called_in_that_moment() -> None:
    async def work(called: bool) -> list[str]:
        turns, done = Turns(), list[str]()
        async with turns.turn("a"):
            gone, stays = (asyncio.create_task(asks(turns, who, done)) for who in "bc")
            await asyncio.sleep(0)
            if not called:
                gone.cancel()
        gone.cancel()
        await asyncio.gather(gone, stays, return_exceptions=True)
        await asks(turns, "d", done)
        return done

    assert asyncio.run(work(called=True)) == asyncio.run(work(called=False)) == ["c", "d"]
