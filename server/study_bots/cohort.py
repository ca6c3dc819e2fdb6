"""All simulated participants of a rehearsal, and the kills of the server while they take part."""

import asyncio
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from random import Random
from urllib.parse import urlsplit

import httpx

from movingout.agents.scripted.populations import PEOPLE, POPULATIONS
from movingout.server.study_bots.faults import FaultInjection, chaos
from movingout.server.study_bots.policies import CirclingPolicy, ScriptedPolicy, SeatPolicy
from movingout.server.study_bots.simulated_participant import ActivityLog, SimulatedParticipant
from movingout.server.study_bots.simulation_plan import SimulationPlan
from movingout.server.study_bots.study_client import (
    GIVE_UP_S,
    RETRIED,
    RETRY_S,
    RequestRefused,
    SimulationError,
    StudyClient,
)

TIMEOUT = httpx.Timeout(30.0)
STAGGER_S = 0.1  # between two arrivals


@dataclass
class Cohort:
    """The participants of one rehearsal; `logs` grow while it runs."""

    base: str  # address of the server, as http://127.0.0.1:8000
    plan: SimulationPlan
    logs: list[ActivityLog] = field(default_factory=list)

    async def take_part(self) -> Sequence[ActivityLog]:
        """Run everybody to the end. Raises SimulationError when one of them cannot continue."""
        limits = httpx.Limits(max_connections=None, max_keepalive_connections=64)
        async with httpx.AsyncClient(base_url=self.base, timeout=TIMEOUT, limits=limits) as http:
            languages = await self._languages(http)
            slots = asyncio.Semaphore(self.plan.at_once)
            try:
                async with asyncio.TaskGroup() as group:
                    for number in range(self.plan.participants):
                        participant = self._participant(http, number)
                        self.logs.append(participant.log)
                        group.create_task(self._run(participant, slots, languages))
                        await asyncio.sleep(STAGGER_S / self.plan.speed)
            except* (SimulationError, RequestRefused) as several:
                raise SimulationError(f"a simulated participant cannot continue: {_first(several)}") from several
        return self.logs

    async def _languages(self, http: httpx.AsyncClient) -> list[str]:
        try:
            study = (await self._study(http)).raise_for_status().json()
        except (httpx.HTTPError, ValueError) as error:
            raise SimulationError(f"no study is being served at {self.base}: {error}") from None
        if not study.get("simulated"):
            raise SimulationError(
                f"{self.base} serves a study for real participants; simulated ones would corrupt its data. "
                "Start it with --rehearse 1 and another --data folder"
            )
        languages: list[str] = study["languages"]
        return languages

    async def _study(self, http: httpx.AsyncClient) -> httpx.Response:
        """What is served; as the pages do, waits while one node of several hands the study to another."""
        waited = 0.0
        while (answer := await http.get("/api/study")).status_code in RETRIED and waited < GIVE_UP_S:
            waited += RETRY_S
            await asyncio.sleep(RETRY_S)
        return answer

    async def _run(self, participant: SimulatedParticipant, slots: asyncio.Semaphore, languages: list[str]) -> None:
        async with slots:
            await participant.take_part(languages)

    def _participant(self, http: httpx.AsyncClient, number: int) -> SimulatedParticipant:
        plan = self.plan
        random = Random(f"{plan.seed} {number}")
        address = urlsplit(self.base)._replace(scheme="wss" if self.base.startswith("https") else "ws").geturl()
        faults = chaos(random) if plan.chaos else FaultInjection(random)
        name = f"simulated-{plan.run}-{number + 1:04d}"
        return SimulatedParticipant(
            name,
            client=StudyClient(http),
            address=address,
            policy=_policy(plan, number),
            faults=faults,
            random=random,
            speed=plan.speed,
        )


def _policy(plan: SimulationPlan, number: int) -> SeatPolicy:
    if not plan.scripted:
        return CirclingPolicy()
    names = [f"{population}{person:02d}" for person in range(1, PEOPLE + 1) for population in POPULATIONS]
    return ScriptedPolicy(names[number % len(names)], plan.seed + number)


async def with_kills(cohort: Cohort, kills: int, restart: Callable[[], None]) -> Sequence[ActivityLog]:
    """Take part while the server is killed and restarted, at equal intervals of the cohort's progress."""
    taking_part = asyncio.create_task(_all(cohort))
    for kill in range(kills):
        while not taking_part.done() and progress(cohort) < (kill + 1) / (kills + 1):
            await asyncio.sleep(0.1)
        if not taking_part.done():
            await asyncio.to_thread(restart)
    return await taking_part


async def _all(cohort: Cohort) -> Sequence[ActivityLog]:
    return await cohort.take_part()


def progress(cohort: Cohort) -> float:
    """The share of all steps that are done, in [0, 1]."""
    shares = [log.done / log.total if log.total else 0.0 for log in cohort.logs]
    return sum(shares) / cohort.plan.participants


def _first(group: BaseException) -> BaseException:
    while isinstance(group, BaseExceptionGroup):
        group = group.exceptions[0]
    return group
