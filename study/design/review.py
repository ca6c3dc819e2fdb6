"""What an experimenter should know before the first participant comes: timeline, pay, missing models, weaknesses."""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import get_args

from movingout.agents.catalogue import check_options_once
from movingout.agents.errors import AgentError
from movingout.agents.live_options import check_admitted_agent, check_live_agent
from movingout.agents.trial import play_a_tick, runs_own_code
from movingout.maps.commands.map_cautions import map_cautions
from movingout.study.design.allocation import Assignment, assign, cells
from movingout.study.design.balance import seat_imbalance
from movingout.study.design.consent_text import contradictions, shared_code, unfilled, unseen
from movingout.study.design.definition import NOTICED_S, Outcome, Study
from movingout.study.design.localized_text import DEFAULT
from movingout.study.design.maps_met import maps_met, unseen_maps
from movingout.study.design.partner_origin import origin_warnings
from movingout.study.design.pooling import apart_by_maps
from movingout.study.design.sections.consent import Element
from movingout.study.design.steps import Step, longest_round_s, planned_seconds, steps
from movingout.study.design.translations import missing_texts, questionnaires_asked

SILENT = ("idle", "person", "ghost")  # agents of the catalogue that take no notice of pings; so do trained ones


@dataclass(frozen=True, slots=True)
class TimelineEntry:
    """Consecutive steps of a kind, as a line of the timeline."""

    title: str
    detail: str
    seconds: float


@dataclass(frozen=True, slots=True)
class Review:
    """What `movingout study check` prints."""

    study: Study
    timeline: tuple[TimelineEntry, ...]
    minutes: float  # at most, for the first slot
    pay: float | None  # for one participant who stays that long
    orders: tuple[Assignment, ...]
    attention: tuple[str, ...]  # sentences, one per attention item: what is expected
    missing: tuple[str, ...]  # sentences, one per agent that cannot be loaded
    refused: tuple[str, ...]  # sentences, one per agent with which no study begins, though one that has begun goes on
    untranslated: tuple[str, ...]  # sentences, one per text and language that is promised and missing
    unfilled: tuple[str, ...]  # sentences, one per blank that participants would read
    contradictions: tuple[str, ...]  # sentences, one per number of the consent that differs from the file
    warnings: tuple[str, ...]
    slow: tuple[str, ...] = ()  # sentences, one per partner that decides too slowly here
    alike: tuple[str, ...] = ()  # sentences, one per question with equal options; with it, too, no study begins

    @property
    def ready(self) -> bool:
        """Whether the study can be run as it is."""
        agents = self.missing or self.refused or self.slow
        return not (agents or self.alike or self.untranslated or self.unfilled or self.contradictions)


def review(study: Study) -> Review:
    """All checks of a study that need no participants."""
    orders = tuple(assign(study, slot) for slot in range(study.units))
    step_order = steps(study, orders[0])
    minutes = planned_seconds(step_order) / 60
    return Review(
        study=study,
        timeline=_timeline(study, step_order),
        minutes=minutes,
        pay=_pay(study, minutes),
        orders=orders,
        attention=tuple(_attention(study)),
        missing=tuple(filter(None, map(_fault_of, agent_ids(study)))),
        refused=tuple(_refused(study)),
        untranslated=missing_texts(study),
        unfilled=unfilled(study),
        contradictions=contradictions(study),
        warnings=tuple(_warnings(study, orders, step_order)),
        alike=tuple(_alike(study)),
    )


def _timeline(study: Study, step_order: tuple[Step, ...]) -> tuple[TimelineEntry, ...]:
    """One line per screen, and one per block with its rounds."""
    pings = {block.id for block in study.blocks if block.pings == "on"}
    stages: list[TimelineEntry] = []
    done: set[str] = set()
    for step in step_order:
        if not step.block:
            stages.append(TimelineEntry(step.kind.replace("-", " "), step.questionnaire, step.seconds))
        elif step.block not in done:
            done.add(step.block)
            inside = [one for one in step_order if one.block == step.block]
            contents = _contents(inside, step.block in pings)
            stages.append(TimelineEntry(f"block {step.block}", contents, planned_seconds(tuple(inside))))
    return tuple(stages)


def _contents(inside: list[Step], pings: bool) -> str:
    rounds = [step for step in inside if step.kind == "round"]
    partners = {step.partner for step in rounds if step.partner}
    forms = sum(step.kind == "questionnaire" for step in inside)
    breaks = sum(step.kind == "break" for step in inside)
    parts = [f"{len(rounds)} rounds of {rounds[0].limit_ticks} ticks"]
    counts = {"partner": len(partners), "questionnaire": forms, "break": breaks}
    parts += [f"{count} {word}{'s' * (count > 1)}" for word, count in counts.items() if count]
    return ", ".join([*parts, *(["pings"] if pings else [])])


def _pay(study: Study, minutes: float) -> float | None:
    return None if study.pay is None else earned(study, minutes)


def earned(study: Study, minutes: float) -> float:
    """Pay for a number of minutes, pro-rated and capped; 0 where the study pays nothing."""
    if study.pay is None:
        return 0.0
    amount = study.pay.per_hour * minutes / 60
    due = min(amount, study.pay.maximum) if study.pay.maximum is not None else amount
    return round(due, study.pay.decimals or None)


def agent_ids(study: Study) -> tuple[str, ...]:
    """All agents that the study may need."""
    ids = [partner.agent for partner in study.partners]
    if study.practice and study.group == 1:
        ids.append(study.practice.agent)
    if study.group == 2 and study.pairing.otherwise == "agent":
        ids.append(study.pairing.agent)
    return tuple(dict.fromkeys(ids))


def _attention(study: Study) -> Iterator[str]:
    """What each attention item expects: an option is given by its place, which is easily mistaken for its text."""
    asked = questionnaires_asked(study)
    for spec in (one for one in study.questionnaires if one.id in asked):
        for item in spec.build(study.languages[0]).items:
            if item.expected is not None:
                option = f", the option {item.options[item.expected]!r}" if item.options else ""
                yield f"attention item {item.id!r} of {spec.id} expects {item.expected}{option}"


def _truth_values(study: Study) -> Iterator[str]:
    for spec in study.questionnaires:
        for item in spec.items:
            if isinstance(item.expected, bool):
                yield (
                    f"attention item {item.id!r} of {spec.id} expects {int(item.expected)}, because YAML reads yes, "
                    "no, on and off as truth values: write the number that is the right answer"
                )


def _refused(study: Study) -> Iterator[str]:
    """Agents with an option given twice, or that would stand still on a map with more items than they see."""
    playable = [name for name in agent_ids(study) if not _fault_of(name)]
    yield from filter(None, (_fault_of(name, check_options_once) for name in playable))
    yield from unseen_maps(study, playable)


def _alike(study: Study) -> Iterator[str]:
    """Questions with options that read alike, so that nobody could say which one was chosen."""
    for spec in study.questionnaires:
        for question in spec.items:
            for language in study.languages:
                shown = [option.text(language).strip() for option in question.options]
                twice = [text for text, number in Counter(shown).items() if number > 1]
                if twice:
                    where = f"question {question.id} of {spec.id} has the option {twice[0]!r}"
                    yield f"{where} more than once, in {language!r}; answers could not be told apart"
                    break


def _fault_of(name: str, check: Callable[[str], None] = check_admitted_agent) -> str:
    """Why no room could play an agent, as far as its id shows."""
    try:
        check(name)
    except AgentError as error:
        return str(error)
    return ""


def own_agents_tried(found: Review) -> Review:
    """The same once each agent of one's own has played a tick where it is met; this takes seconds."""
    missing = list(found.missing)
    for name in agent_ids(found.study):
        if _fault_of(name, check_live_agent) or not runs_own_code(name):
            continue
        try:
            play_a_tick(name, found.study.map_source(first_map(found.study, name)))
        except AgentError as error:
            missing.append(str(error))
    return replace(found, missing=tuple(missing))


def first_map(study: Study, agent: str) -> str:
    """The first map of the data on which an agent is met, or the practice map if it is met only there."""
    met = (name for met_agent, name in maps_met(study) if met_agent == agent)
    return next(met, study.blocks[0].maps[0])


# ---- weaknesses of the design -----------------------------------------------------------------------------------


def _warnings(study: Study, orders: tuple[Assignment, ...], step_order: tuple[Step, ...]) -> Iterator[str]:
    yield from _role_confound(orders)
    yield from seat_imbalance(study, orders)
    yield from _order_confounds(study)
    yield from _ping_weaknesses(study)
    yield from _without_effect(study, step_order)
    whole = cells(study)
    if study.units % whole:
        who = "pairs" if study.group == 2 else "participants"
        yield f"{study.units} {who} do not complete the square: orders are fully balanced with a multiple of {whole}"
    minutes = planned_seconds(step_order) / 60
    if minutes > study.minutes:
        yield f"participants were told {study.minutes} minutes, and it can take {minutes:.0f}"
    yield from _unmet_partners(study, step_order)
    yield from _impatient_partners(study)
    yield from origin_warnings(study)
    yield from map_warnings(study)
    yield from _truth_values(study)
    missing = [name for name in get_args(Element) if name not in study.consent.covers]
    if missing:
        yield f"the consent does not mention (in `covers`): {', '.join(missing)}"
    if not study.protocol:
        yield "protocol is empty: the number assigned by the review board is part of every export"
    if study.pay is not None and study.pay.maximum is None:
        yield "pay has no maximum: whoever leaves the page open is paid for every minute until they have finished"
    if study.codes != "unique" and len(set(study.codes.values())) < len(study.codes):
        yield "two outcomes have the same completion code and cannot be told apart when paying"
    yield from shared_code(study)
    yield from unseen(study)
    if without := _without_code(study):
        yield f"codes has none for {', '.join(without)}: they get random ones, which a platform does not know"


def _without_code(study: Study) -> list[str]:
    """The outcomes that can occur but have no code in a file that fixes codes."""
    if study.codes == "unique":
        return []
    never = ("no-partner", "partner-left") if study.group == 1 else ()
    has = {*study.codes, *(["dropped-out"] if "withdrew" in study.codes else [])}  # which has that of `withdrew`
    return [outcome for outcome in get_args(Outcome) if outcome not in has and outcome not in never]


def _unmet_partners(study: Study, step_order: tuple[Step, ...]) -> Iterator[str]:
    """Blocks whose time may run out before every partner has been met as often as planned."""
    for block in study.blocks:
        rounds = [step for step in step_order if step.block == block.id and step.kind == "round"]
        longest = longest_round_s(block)
        if block.limit_minutes and len(block.partners) > 1 and any(step.seconds < longest for step in rounds):
            yield (
                f"block {block.id}: limit_minutes ends it after {block.limit_minutes:g} minutes with all partners "
                f"together, and its rounds can take {len(rounds) * longest / 60:.0f}: partners late in the order may "
                "be met in fewer rounds, or never"
            )


def _impatient_partners(study: Study) -> Iterator[str]:
    """Partners who can end the practice while the participant is still reading the screen."""
    practice = study.practice
    if practice is None or practice.tutorial:
        return
    if any(item.size == "large" for item in study.load_map(practice.map).items):
        return
    agent = practice.agent if study.group == 1 else study.pairing.agent if study.pairing.otherwise == "agent" else ""
    if agent not in ("", "idle"):
        yield (
            f"practice: {agent} can deliver everything on {practice.map} alone, so that the practice ends before the "
            "participant has moved; practice: tutorial waits for everybody"
        )


def _role_confound(orders: tuple[Assignment, ...]) -> Iterator[str]:
    seats: dict[str, set[int]] = defaultdict(set)
    for order in orders:
        for visit in order.visits:
            seats[visit.partner].update(turn.seat for turn in visit.turns)
    if len(seats) < 2 or len(set(map(frozenset, seats.values()))) == 1:
        return
    red = [name for name, found in seats.items() if found == {1}]
    blue = [name for name, found in seats.items() if found == {0}]
    yield (
        "role and model are confounded: participants meet "
        + " and ".join(f"{', '.join(names)} only as {seat}" for names, seat in ((red, "red"), (blue, "blue")) if names)
        + "; a difference between these models may be a difference between the seats (seats: alternate balances them)"
    )


def _order_confounds(study: Study) -> Iterator[str]:
    for block in study.blocks:
        where = f"block {block.id}:"
        if len(block.partners) > 1 and block.partner_order == "fixed":
            yield f"{where} everybody meets the partners in the same order, so learning favours the later ones"
        if len(block.partners) > 1 and block.partner_order == "random":
            yield f"{where} partner_order is random, so balance is left to chance; balanced guarantees it"
        if len(block.maps) > 1 and block.map_order == "fixed":
            yield f"{where} everybody plays the maps in the same order, so maps and learning are confounded"
    firsts = [set(block.partners) for block in study.blocks if block.partners]
    if len(firsts) > 1 and not set.intersection(*firsts):
        yield "some partners always come in an earlier block than others, so order and model are confounded"
    for blocks in apart_by_maps(study):
        yield (
            f"blocks {' and '.join(blocks)}: some partners are met on other maps than others, so reports keep blocks "
            "with different maps apart, and partners who are in none together are not compared"
        )


def _without_effect(study: Study, step_order: tuple[Step, ...]) -> Iterator[str]:
    """Entries of the file that have no effect."""
    twice = [name for name, count in Counter(study.languages).items() if count > 1]
    if twice:
        yield f"languages: {', '.join(twice)} is named more than once"
    yield from _unused(study)
    if study.group == 2 and study.pairing.return_s < NOTICED_S:
        yield (
            f"pairing: return_s is {study.pairing.return_s}, and between rounds a closed page is noticed after "
            f"{NOTICED_S:.0f} s: only within a round is the wait shorter"
        )
    for block in study.blocks:
        unused = [name for name in ("split", "variants") if name in block.model_fields_set]
        if block.challenge == 1 and unused:
            yield f"block {block.id}: {' and '.join(unused)} has no effect without challenge: 2"
        breaks = any(step.kind == "break" and step.block == block.id for step in step_order)
        if block.break_after_maps and not breaks:
            maps = f"{len(block.maps)} map{'s' * (len(block.maps) > 1)}"
            yield f"block {block.id}: no break comes, because break_after_maps is {block.break_after_maps} of {maps}"


def _unused(study: Study) -> Iterator[str]:
    """Entries that nothing refers to, and labels for the ends of something that is not a scale."""
    asked = questionnaires_asked(study)
    for spec in study.questionnaires:
        if spec.id not in asked:
            places = "demographics, after_round, after_partner or at_end"
            yield f"questionnaire {spec.id} is never asked: name it in {places}, or remove it"
        for item in spec.items:
            if item.ends and not item.build(DEFAULT).is_rated:
                yield f"questionnaire {spec.id}: ends of {item.id} has no effect, because a {item.kind} is no scale"
    met = {name for block in study.blocks for name in block.partners}
    for partner in study.partners:
        if partner.id not in met:
            letter = ", and takes a letter from those who are" if study.group == 1 else ""
            yield f"partner {partner.id} is in no block: it is never met{letter}; name it in one, or remove it"


def map_warnings(study: Study) -> Iterator[str]:
    """Maps of one's own that cannot be played as they should, or would be taken for others in the data."""
    maps = list(dict.fromkeys(name for block in study.blocks for name in block.maps))
    practised = [study.practice.map] if study.practice and not study.practice.tutorial else []
    yield from map_cautions(map(study.map_source, [*maps, *practised]))
    files: dict[str, list[str]] = defaultdict(list)
    for name in maps:
        files[study.load_map(name).name].append(name)
    for name, several in files.items():
        if several[1:]:
            yield (
                f"{' and '.join(several)} have one name, {name}, and are one map in recordings and training sets; "
                "change it in the files"
            )


def _ping_weaknesses(study: Study) -> Iterator[str]:
    on = [block for block in study.blocks if block.pings == "on"]
    if on and len(on) < len(study.blocks):
        yield (
            f"pings are on in {', '.join(block.id for block in on)} only, and blocks always come in the same order, so "
            "pings and learning are confounded"
        )
    met = dict.fromkeys(study.partner(name).agent for block in on for name in block.partners)
    deaf = [agent for agent in met if agent.partition(":")[0] in SILENT or "@" in agent]
    if deaf:
        yield f"pings are on, and these partners do not answer them: {', '.join(deaf)} (scripted does)"
