"""A language model in a seat, beside a stand-in for its server: it plays on whatever comes back, and says what came."""

import json
import re
import threading
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import pytest

from movingout import check_agent, play
from movingout.agents.base import EpisodeInfo
from movingout.agents.baseline.delayed_agent import DelayedAgent
from movingout.agents.catalogue import agent_card, agent_cards, load_agent, open_to_all
from movingout.agents.data.rollout import rollout
from movingout.agents.decision_trace import decision_trace
from movingout.agents.errors import AgentError
from movingout.agents.llm import agent
from movingout.agents.llm.agent import VAIN, LlmAgent
from movingout.agents.llm.answers import SKILLS
from movingout.agents.llm.chat import ChatError, Message
from movingout.agents.llm.model_id import KEY, QUESTIONS, endpoint_key
from movingout.agents.observation.seat_observation import observe
from movingout.agents.recording_metadata import seat_info
from movingout.maps import load_map
from movingout.matches.execution.lockstep import Lockstep
from movingout.matches.match import Match
from movingout.matches.results.unanswered import unanswered
from movingout.world import World
from movingout.world.ping import HelpPing
from tests.agents.llm.stand_in import Reply, StandIn, said, stand_in


def answer(*skills: object, plan: str = "I go.") -> str:
    return json.dumps({"plan": plan, "skills": skills})


def fetch(item: int) -> dict[str, object]:
    return {"skill": "fetch", "item": item}


def first_open(messages: list[Message]) -> Reply:
    """A model that fetches the first item that is not delivered."""
    lines = re.findall(r"Item (\d+): (.*)", messages[-1]["content"])
    left = [int(number) for number, line in lines if "delivered" not in line]
    return said(answer(*map(fetch, left)))


@pytest.fixture
def server() -> Iterator[StandIn]:
    with stand_in(first_open) as running:
        yield running


def played(agent: LlmAgent, map_name: str = "SingleRotation", ticks: int = 60) -> list[Mapping[str, Any]]:
    """The decision traces of some ticks beside a scripted partner."""
    steps = rollout(load_map(map_name), (agent, load_agent("scripted")), seed=0, ticks=ticks)
    return [decision_trace(agent) for _ in steps]


def waiting(chat: Callable[[list[Message]], str], every_s: float = 1.0, fallback: str = "help") -> LlmAgent:
    return LlmAgent(lambda messages: chat(list(messages)), 1.0, every_s, fallback, waits=True, sleep=lambda _: None)


@pytest.mark.slow
def test_a_match_waits_for_the_model_and_is_repeatable(server: StandIn) -> None:
    agent_id = f"llm:model=m,url={server.url},wait=yes"
    first, again = (play(agent_id, "scripted", "SingleRotation", episodes=1)[0] for _ in range(2))
    assert (first.delivered, first.failure) == (first.items, "")
    assert first.play_hash == again.play_hash


def test_it_keeps_the_contract(server: StandIn) -> None:
    found = check_agent(lambda: load_agent(f"llm:model=m,url={server.url}"), ["HandOff"], 15)
    assert found.episodes == 6 and not found.deterministic
    found = check_agent(lambda: load_agent(f"llm:model=m,url={server.url},wait=yes,lag=1"), ["HandOff"], 8)
    assert found.episodes == 6 and not found.deterministic


def test_slow_answers_hold_up_no_decision(server: StandIn) -> None:
    server.reply = lambda messages: Reply(first_open(messages).body, delay_s=0.5)
    agent = load_agent(f"llm:model=m,url={server.url},every=0.5")
    spec, seen, longest = load_map("SingleRotation"), [], 0.0
    agent.reset(EpisodeInfo(spec, 0, 0, 100))
    world, until = World(spec), time.monotonic() + 10.0
    while "answer" not in (trace := decision_trace(agent)) and time.monotonic() < until:
        world.step([[0.0, 0.0, 0.0]] * 2)
        observation = observe(spec, world.state(), 0)
        begun = time.thread_time()
        agent.act(observation)
        longest = max(longest, time.thread_time() - begun)
        seen.append(decision_trace(agent)["skill"])
        time.sleep(0.05)
    assert seen[0] == "help" and seen[-1] == "fetch 0" and len(seen) > 5
    assert longest < 0.5  # s of the processor
    told: dict[str, Any] = dict(trace)
    assert told["latency_s"] >= 0.5 and told["prompt"].startswith("SingleRotation") and told["fault"] == ""


@pytest.mark.parametrize(
    ("text", "note"),
    [
        ("I would rather talk.", "no JSON object"),
        (answer({"skill": "dance"}), "'dance'"),
        (answer(fetch(9)), "no item 9"),
    ],
)
def test_after_rubbish_the_last_skill_goes_on_and_the_model_is_told(text: str, note: str) -> None:
    asked: list[str] = []

    def chat(messages: list[Message]) -> str:
        asked.append(messages[-1]["content"])
        return answer(fetch(0)) if len(asked) == 1 else text

    traces = played(waiting(chat), ticks=25)
    wrong = next(trace for trace in traces if trace.get("question") == 2)
    assert wrong["skill"] == "fetch 0" and wrong["plan"] == "I go." and note in wrong["note"]
    assert wrong["counts"]["rubbish"] == 1 and "Not done: " in asked[2] and note in asked[2]


def test_an_answer_that_ends_within_an_emoji_is_recorded() -> None:
    traces = played(waiting(lambda _: answer(fetch(0)) + "\ud83d"), ticks=3)
    told = next(trace for trace in traces if "question" in trace)
    assert told["answer"] == answer(fetch(0)) + "\\ud83d" and told["counts"]["answers"] == 1


@pytest.mark.parametrize("fault", ["busy", "timeout", "unreachable", "http"])
def test_without_answers_the_fallback_is_done_and_faults_are_counted(
    fault: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(agent, "VAIN", 99)

    def chat(_: list[Message]) -> str:
        raise ChatError(fault, "no luck")

    with pytest.warns(RuntimeWarning, match=r"no usable answer to 3 questions \(no luck\); meanwhile its fallback"):
        traces = played(waiting(chat), ticks=130)
    told = [trace for trace in traces if "question" in trace]
    assert told[-1]["counts"][fault] == told[-1]["question"] >= 2 and told[0]["note"] == "no luck"
    assert {trace["skill"] for trace in traces} == {"help"}
    assert any(trace["errand"] == "Lift" for trace in traces)  # the partner took an end of the heavy item


@pytest.mark.parametrize(("useful", "failure"), [(0, "red (silent), its account: not one usable answer to "), (1, "")])
def test_a_match_without_one_useful_answer_fails_and_others_count_the_questions(useful: int, failure: str) -> None:
    asked: list[int] = []

    def chat(_: list[Message]) -> str:
        asked.append(1)
        if len(asked) > useful:
            raise ChatError("http", "HTTP 500: oops")
        return answer(fetch(0))

    silent = DelayedAgent(waiting(chat), 1)
    players = {"silent": silent, "idle": load_agent("idle")}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        (result,) = Lockstep(load=players.__getitem__).play([Match("HandOff", "idle", "silent", 0, ticks=40)])
    assert result.failure.startswith(failure) and (result.ending == "failed") == (useful == 0)
    if useful:
        counts = {"red_llm_questions": len(asked), "red_llm_useful": 1, "red_llm_answers": 1, "red_llm_left_out": 0}
        assert result.counts == counts | {"red_llm_http": len(asked) - 1}
        assert unanswered([result, result]) == (len(asked) - 1, len(asked), 1, 1)
    else:
        assert "(HTTP 500: oops), so only its fallback played" in result.failure and not result.counts


@pytest.mark.parametrize(
    ("useful", "why"),
    [
        (0, "not one usable answer to 10 questions (no answer within 8 s), so only its fallback played"),
        (2, "no answer to 10 questions in a row (no answer within 8 s)"),
    ],
)
def test_a_match_that_waits_ends_when_no_answer_is_to_be_expected(useful: int, why: str) -> None:
    """A server that has died took a time-out for each question of the match, which failed or counted as the model's."""
    asked: list[int] = []

    def chat(_: list[Message]) -> str:
        asked.append(1)
        if len(asked) <= useful:
            return answer(fetch(0))
        raise ChatError("timeout", "no answer within 8 s")

    players = {"silent": DelayedAgent(waiting(chat), 1), "idle": load_agent("idle")}
    with warnings.catch_warnings(action="ignore"):
        (result,) = Lockstep(load=players.__getitem__).play([Match("HandOff", "idle", "silent", 0, ticks=200)])
    assert len(asked) - useful == VAIN == 10 and result.ending == "failed" and result.ticks < 200
    assert why in result.failure


def test_answers_that_cannot_be_used_are_the_models_play() -> None:
    asked: list[int] = []

    def chat(_: list[Message]) -> str:
        asked.append(1)
        return answer(fetch(0)) if len(asked) == 1 else "I would rather talk."

    assert len(played(waiting(chat, every_s=0.2), ticks=40)) == 40 and len(asked) > VAIN + 1


def test_a_question_that_is_open_at_the_end_is_none_without_an_answer() -> None:
    """Each match of a model that is not waited for ends with one."""
    held, end = threading.Event(), threading.Event()

    def chat(_: list[Message]) -> str:
        return answer(fetch(0)) if not held.is_set() else str(end.wait(10.0))

    agent = LlmAgent(lambda messages: chat(list(messages)), 1.0, 0.5)
    for _ in rollout(load_map("HandOff"), (agent, load_agent("idle")), seed=0, ticks=60):
        if agent.episode_counts[QUESTIONS]:
            held.set()
        elif open_question := agent._questions._open:
            open_question.over.wait(10.0)
    assert not agent._questions.ready, "one is open"
    assert agent.episode_counts == {"llm_questions": 1, "llm_useful": 1, "llm_answers": 1, "llm_left_out": 0}
    end.set()


@pytest.mark.parametrize("skill", SKILLS)
@pytest.mark.parametrize("map_name", ["HandOff", "FourCorners", "DistancePriority"])
def test_every_skill_can_be_done_on_any_map(skill: str, map_name: str) -> None:
    numbers = iter(range(10**6))
    chat = lambda _: answer({"skill": skill, "item": next(numbers) % len(load_map(map_name).items)})  # noqa: E731
    traces = played(waiting(chat, every_s=2.0), map_name, 80)
    done = "fetch" if map_name == "FourCorners" and skill == "hand_over" else skill  # everything is heavy there
    assert len(traces) == 80 and any(str(trace["skill"]).startswith(done) for trace in traces)


def test_items_are_handed_over_where_two_cannot_pass() -> None:
    def chat(messages: list[Message]) -> str:
        text = messages[-1]["content"]
        failed = re.findall(r"Not done: hand_over (\d)", text)
        far = [number for number, x in re.findall(r"Item (\d): \w+ \w+ at \((-?[\d.]+)", text) if float(x) < -0.4]
        wanted = [number for number in far if number not in failed]
        return answer(*({"skill": "hand_over", "item": number} for number in wanted or ["3"]))

    spec = load_map("HandOff")
    steps = list(rollout(spec, (waiting(chat), load_agent("scripted")), seed=0, ticks=400))
    assert {int(step.after.held[1]) for step in steps} - {-1}  # the partner has taken what was brought


def test_a_ping_is_told() -> None:
    asked: list[str] = []

    def chat(messages: list[Message]) -> str:
        asked.append(messages[-1]["content"])
        return answer("help")

    agent = waiting(chat)
    spec = load_map("HandOff")
    agent.reset(EpisodeInfo(spec, 0, 0, 100))
    world = World(spec)
    world.step([[0.0, 0.0, 0.0]] * 2)
    agent.act(observe(spec, world.state(), 0, pings=(HelpPing(1, 1, 2, 0.0, 0.0), HelpPing(1, 0, 3, 0.0, 0.0))))
    assert "Your partner asks for help with item 2." in asked[0] and "help with item 3" not in asked[0]


def test_what_is_recorded_is_bounded_and_has_no_key(server: StandIn, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(KEY, "sk-secret")
    server.reply = lambda _: said(answer(fetch(0)) + " sk-secret " * 10_000)
    agent_id = f"llm:model=m,url={server.url},wait=yes"
    agent = load_agent(agent_id)
    assert isinstance(agent, LlmAgent)
    traces = played(agent, ticks=5)
    assert server.keys[-1] == "Bearer sk-secret"
    assert "sk-secret" not in json.dumps(traces) and len(json.dumps(traces[-1])) < 12_000
    assert seat_info(agent_id).name == agent_id


@pytest.mark.parametrize(
    ("key", "why"),
    [
        ("sk-one\nsk-two", "a space or a line break"),
        ("sk-one sk-two", "a space or a line break"),
        ("sk-one\xa0sk-two", "a space or a line break"),
        ("sk-\u200bone", "a character that no key has"),
        ("“sk-one”", "a character that no key has"),
        ("sk-\x7fone", "a character that no key has"),
    ],
)
def test_a_key_that_cannot_be_sent_is_told_without_it(key: str, why: str) -> None:
    """The client's error had the whole key in it, or it was the server that gave no JSON."""
    with pytest.raises(AgentError, match=why) as error:
        endpoint_key(key)
    assert "sk-" not in str(error.value) and KEY in str(error.value)


def test_the_key_of_the_environment_is_checked_before_it_is_sent(
    server: StandIn, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(KEY, "sk-one\nsk-two")
    with pytest.raises(AgentError, match="a space or a line break in it; set it to one key"):
        load_agent(f"llm:model=m,url={server.url}")
    monkeypatch.setenv(KEY, " sk-one\r\n")
    load_agent(f"llm:model=m,url={server.url}")


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ("", "name the model"),
        ("model=m", "name the address"),
        ("model=m,url=localhost:8080", "no address of a server"),
        ("model=m,url=ftp://x/v1", "no address of a server"),
        ("model=m,url=http://[::1", "no address of a server"),
        ("model=m,url=http://me:secret@x/v1", f"environment variable {KEY}"),
        ("model=m,url=http://x/v1?key=secret", f"environment variable {KEY}"),
        ("model=m,url=http://127.0.0.1:9/v1", "nothing answers at http://127.0.0.1:9/v1 .*; start the server"),
        ("model=m,url=http://127.0.0.1:9/v1,wait=perhaps", "wait is yes or no"),
        ("model=m,url=http://127.0.0.1:9/v1,wait=yes,timeout=60", "timeout lies between 0.1 and 9.5"),
        ("model=m,url=http://127.0.0.1:9/v1,every=soon", "every lies between"),
        ("model=m,url=http://127.0.0.1:9/v1,fallback=fetch", "fallback is one of help, wait, alone"),
        ("model=m,url=http://127.0.0.1:9/v1,heat=1", "options: model, url, wait"),
    ],
)
def test_a_wrong_id_is_answered_in_a_sentence(options: str, why: str) -> None:
    with pytest.raises(AgentError, match=why):
        load_agent(f"llm:{options}")


def test_a_card_needs_no_server_and_says_what_it_is() -> None:
    card = agent_card("llm:model=llama3.2:3b,url=http://127.0.0.1:9/v1/")
    assert (card.name, card.kind) == ("llama3.2:3b", "llm") and "http://127.0.0.1:9/v1 " in card.description
    with pytest.raises(AgentError, match="name the address"):
        agent_card("llm:model=m")


def test_only_the_operator_names_addresses() -> None:
    agent_id = "llm:model=m,url=http://10.0.0.1/v1"
    assert "llm" not in [card.id for card in agent_cards()]
    inside = agent_id.replace(",", ";")
    assert not any(map(open_to_all, (agent_id, "llm", f"late:agent={inside}", f"late:seed=1,agent={inside}")))
