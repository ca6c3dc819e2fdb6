"""What a worker says to its driver."""

import io
import json

from movingout.matches.execution.worker import WorkerOutput


def test_a_heartbeat_that_interrupts_a_message_is_left_out() -> None:
    class Interrupted(io.StringIO):
        """A stream during whose flush a signal arrives."""

        def flush(self) -> None:
            output.heartbeat()

    stream = Interrupted()
    output = WorkerOutput(stream)
    output.write({"kind": "ready"})
    output.heartbeat()
    assert [json.loads(line)["kind"] for line in stream.getvalue().splitlines()] == ["ready", "heartbeat"]
