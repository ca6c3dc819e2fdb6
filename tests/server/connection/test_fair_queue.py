"""Who asks for much waits for itself; whoever stops waiting is passed over."""

import asyncio

from movingout.server.connection.fair_queue import FairQueue


async def asks(queue: FairQueue, who: str, done: list[str]) -> None:
    async with queue.turn(who):
        done.append(who)
        await asyncio.sleep(0)


def test_addresses_take_turns_each_in_its_order() -> None:
    async def work() -> list[str]:
        queue, done = FairQueue(), list[str]()
        await asyncio.gather(*(asks(queue, who, done) for who in "aaaabab"), asks(queue, "c", done))
        await asks(queue, "d", done)
        return done

    assert "".join(asyncio.run(work())) == "aabcabaa" + "d"


def test_who_has_asked_for_too_much_has_no_place_and_who_has_not_has_one() -> None:
    async def work() -> None:
        queue, done = FairQueue(), list[str]()
        asked = [asyncio.create_task(asks(queue, "a", done)) for _ in range(3)]
        await asyncio.sleep(0)
        assert not queue.has_place("a", most=8, most_of_one=3) and queue.has_place("b", most=8, most_of_one=3)
        assert not queue.has_place("a", most=3, most_of_one=8) and queue.has_place("b", most=3, most_of_one=8)
        assert not queue.has_place("b", most=1, most_of_one=8), "others have places of their own, too, but not endless"
        await asyncio.gather(*asked)
        assert queue.has_place("a", most=8, most_of_one=1)

    asyncio.run(work())


def test_who_stops_waiting_is_passed_over_also_when_called_in_that_moment() -> None:
    async def work(called: bool) -> list[str]:
        queue, done = FairQueue(), list[str]()
        async with queue.turn("a"):
            gone, stays = (asyncio.create_task(asks(queue, who, done)) for who in "bc")
            await asyncio.sleep(0)
            if not called:
                gone.cancel()
        gone.cancel()
        await asyncio.gather(gone, stays, return_exceptions=True)
        await asks(queue, "d", done)
        return done

    assert asyncio.run(work(called=True)) == asyncio.run(work(called=False)) == ["c", "d"]
