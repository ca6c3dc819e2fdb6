"""From a trained network to the one ONNX graph that plays: normalisation, whole sampler and all."""

import tempfile
import warnings
from pathlib import Path

import torch
from torch import Tensor, nn

from agents.onnx_guard import check_onnx
from agents.policies.policy import Policy
from agents.policy_spec import ACTION_WIDTH

OPSET = 17


def export_policy(policy: Policy) -> bytes:
    """ONNX of `observation` (B, To, D) and, for diffusion, `noise` (B, R, H, 5) to `chunk` (B, H, 5)."""
    spec = policy.spec
    observation = torch.zeros(2, spec.obs_horizon, spec.features)
    noise = torch.zeros(2, max(spec.noise_rows, 1), spec.horizon, ACTION_WIDTH)
    names = ["observation", "noise"] if spec.noise_rows else ["observation"]
    return export(policy, (observation, noise), names, ["chunk"])


def export(module: nn.Module, example: tuple[Tensor, ...], inputs: list[str], outputs: list[str]) -> bytes:
    """ONNX of a module, its first axis free. Raises CheckpointError if the result would be refused when loaded."""
    module = module.eval().cpu()
    free = {name: {0: "batch"} for name in (*inputs, *outputs)}
    with tempfile.TemporaryDirectory() as folder, torch.inference_mode(), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the exporter warns of its successor, which needs two more packages
        path = Path(folder) / "network.onnx"
        torch.onnx.export(
            module, example, path, input_names=inputs, output_names=outputs, dynamic_axes=free,
            opset_version=OPSET, dynamo=False,
        )  # fmt: skip
        data = path.read_bytes()
    check_onnx(data)
    return data
