"""Where networks run: on the CPU, or on a GPU when the environment asks for it."""

import os

import onnxruntime

from movingout.agents.errors import AgentError

VARIABLE = "MOVINGOUT_DEVICE"
PROVIDERS = {"cpu": ["CPUExecutionProvider"], "cuda": ["CUDAExecutionProvider", "CPUExecutionProvider"]}


def providers() -> list[str]:
    """onnxruntime's execution providers, best first, for the device in MOVINGOUT_DEVICE (default: cpu).

    Raises AgentError for an unknown device, or one that this build of onnxruntime does not support.
    """
    device = os.environ.get(VARIABLE) or "cpu"
    if device not in PROVIDERS:
        raise AgentError(f"{VARIABLE}={device}: networks run on {' or '.join(PROVIDERS)}")
    wanted = PROVIDERS[device]
    if wanted[0] not in onnxruntime.get_available_providers():
        raise AgentError(f"{VARIABLE}={device}: this onnxruntime does not support it; install onnxruntime-gpu instead")
    return wanted
