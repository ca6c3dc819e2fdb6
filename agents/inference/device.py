"""Where networks run: on the processor, or on a GPU for whoever asks for it in the environment."""

import os

import onnxruntime

from movingout.agents.errors import AgentError

VARIABLE = "MOVINGOUT_DEVICE"
PROVIDERS = {"cpu": ["CPUExecutionProvider"], "cuda": ["CUDAExecutionProvider", "CPUExecutionProvider"]}


def providers() -> list[str]:
    """Those of onnxruntime, best first, for the device that MOVINGOUT_DEVICE names (cpu when it is not set).

    Raises AgentError for another name, and for a device that this onnxruntime was not made for.
    """
    device = os.environ.get(VARIABLE) or "cpu"
    if device not in PROVIDERS:
        raise AgentError(f"{VARIABLE}={device}: networks run on {' or '.join(PROVIDERS)}")
    wanted = PROVIDERS[device]
    if wanted[0] not in onnxruntime.get_available_providers():
        raise AgentError(f"{VARIABLE}={device}: this onnxruntime cannot; install onnxruntime-gpu in its place")
    return wanted
