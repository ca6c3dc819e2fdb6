"""A study file of few lines, and the faults that are found in one."""

import pytest

from movingout.study.design.study_file import parse_study
from movingout.study.errors import StudyFileError

SMALL = """\
format: 1
id: pilot
title: {en: A pilot, de: Ein Vorversuch}
participants: 4
consent:
  version: "1"
  text: We record how you play.
partners:
  - {id: one, agent: scripted}
  - {id: two, agent: "idle"}
blocks:
  - id: play
    partners: [one, two]
    maps: [HandOff, FourCorners]
    after_partner: [short]
questionnaires:
  - id: short
    base: movingout-paper-nine
    without: [future]
    shuffle: true
    items:
      - {id: attention, kind: likert7, text: Please choose 2., expected: 2}
debrief: {text: They were programs.}
"""


def faults(text: str) -> list[tuple[int, str, str]]:
    """Line, path and message of each."""
    with pytest.raises(StudyFileError) as caught:
        parse_study(text)
    return [(fault.line, fault.path, fault.message) for fault in caught.value.faults]
