"""Answers to the questionnaire: one line of JSON per click, on the disk before the browser hears "saved"."""

import json
import time
from pathlib import Path

from movingout.maps.errors import MovingOutError
from movingout.recordings.text_lines import append_line, read_lines

MOST_BYTES = 400_000  # of one seat; a whole questionnaire takes a few thousand


class TooManyAnswers(MovingOutError):
    """More was answered at a seat than any questionnaire asks."""


class AnswerLog:
    """The answers of all rooms, one file per room and seat. Blocks for the disk: call it in a thread."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def save(self, room_id: str, seat: int, question: str, value: int, text: str, elapsed_ms: float) -> None:
        """Append and fsync. Raises OSError and TooManyAnswers."""
        self._folder.mkdir(parents=True, exist_ok=True)
        answer = {"question": question, "value": value, "text": text, "elapsed_ms": elapsed_ms, "at": time.time()}
        line = json.dumps(answer, ensure_ascii=False)
        if not append_line(self._path(room_id, seat), line, MOST_BYTES):
            raise TooManyAnswers("too much was answered at this seat")

    def of(self, room_id: str, seat: int) -> dict[str, dict[str, object]]:
        """The newest answer to each question; a line cut short by a crash is left out."""
        try:
            lines = read_lines(self._path(room_id, seat))
        except FileNotFoundError:
            return {}
        newest: dict[str, dict[str, object]] = {}
        for line in lines:
            try:
                answer = json.loads(line)
            except ValueError:
                continue
            newest[answer["question"]] = {"value": answer["value"], "text": answer["text"]}
        return newest

    def _path(self, room_id: str, seat: int) -> Path:
        return self._folder / f"{room_id}-{seat}.jsonl"
