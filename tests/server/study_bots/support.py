"""Studies that take a minute."""

_HEAD = """
format: 1
title: {en: Playing with partners, de: Spielen mit Partnern}
languages: [en, de]
seed: 1
minutes: 5
consent:
  version: "1"
  text:
    en: |
      # Taking part

      This is research. It takes about five minutes.
    de: |
      # Teilnahme

      Dies ist Forschung. Es dauert etwa fünf Minuten.
  boxes:
    - {id: adult, text: {en: I am 18 or older., de: Ich bin 18 oder älter.}, required: true}
    - {id: release, text: {en: My recordings may be published., de: Meine Aufnahmen dürfen veröffentlicht werden.}}
pay: {currency: USD, per_hour: 20}
gate: {rtt_ms: 2000}
"""
_AGENTS = """
id: short-agents
participants: 4
practice: {map: Simple, limit_ticks: 300, agent: scripted}
partners:
  - {id: helper, agent: scripted}
  - {id: still, agent: idle}
blocks:
  - id: play
    partners: [helper, still]
    maps: [HandOff, SingleRotation]
    seats: alternate
    limit_ticks: TICKS
    break_after_maps: 1
    after_partner: [movingout-paper-nine]
at_end: [nasa-tlx]
debrief:
  text: {en: The partners were programs., de: Die Partner waren Programme.}
"""
_PAIRS = """
id: short-pairs
participants: 4
group: 2
practice: {map: Simple, limit_ticks: 300}
pairing: {wait_s: WAIT, return_s: 30}
blocks:
  - id: play
    maps: [HandOff]
    seats: both
    limit_ticks: TICKS
    after_round: [how-was-it]
questionnaires:
  - id: how-was-it
    items:
      - {id: fun, kind: likert7, text: {en: It was fun., de: Es hat Spaß gemacht.}}
      - {id: comment, kind: text, text: {en: "What else?", de: "Was noch?"}}
"""


def agents_text(ticks: int = 30) -> str:
    """A study of people with agents: two partners, two maps each."""
    return _HEAD + _AGENTS.replace("TICKS", str(ticks))


def pairs_text(ticks: int = 30, wait_s: int = 60) -> str:
    """A study of pairs: one map in both seats."""
    return _HEAD + _PAIRS.replace("TICKS", str(ticks)).replace("WAIT", str(wait_s))
