"""The policies: what they learn, what they sample, and that the exported network gives the same numbers."""

import numpy as np
import pytest
import torch

from movingout.agents.checkpoint.card import OTHER_MAPS
from movingout.agents.checkpoint.onnx_interface import onnx_interface
from movingout.agents.inference.network import PolicyNetwork
from movingout.agents.kinds.policy import build_policy
from movingout.agents.policies.diffusion_policy import Diffusion, Flow
from movingout.agents.policies.encoders import alike_for_items
from movingout.agents.policies.export import MOST_MAPS, card_maps, export_policy, halved_weights
from movingout.world.observation import ITEM_COLUMNS
from tests.agents.learning import tiny_spec

pytestmark = pytest.mark.slow

VARIANTS = [
    {"kind": "mlp"},
    {"kind": "gru"},
    {"kind": "dp", "process": "flow"},
    {"kind": "dp", "process": "ddim", "sample_steps": 5},
    {"kind": "dp", "process": "ddpm", "train_steps": 6, "sample_steps": 6},
    {"kind": "dp", "process": "ddim", "denoiser": "unet", "sample_steps": 3},
    {"kind": "dp", "process": "flow", "denoiser": "items"},
]


@pytest.mark.parametrize("variant", VARIANTS, ids=lambda variant: "-".join(map(str, variant.values())))
def test_an_exported_policy_gives_the_numbers_of_the_trained_one(variant: dict[str, object]) -> None:
    torch.manual_seed(0)
    spec = tiny_spec(**variant)
    policy = build_policy(spec).eval()
    policy.fit_normaliser(torch.randn(spec.features), torch.rand(spec.features))
    policy.load_state_dict(halved_weights(policy))  # as they are stored
    data = export_policy(policy)
    assert onnx_interface(data)[1] == {"chunk": ("batch", 8, 5)}
    served = PolicyNetwork(spec, data)
    seen = np.random.default_rng(1).standard_normal((3, 2, spec.features), dtype=np.float32)
    noise = np.random.default_rng(7).standard_normal((3, max(policy.noise_rows, 1), 8, 5), dtype=np.float32)
    with torch.inference_mode():
        expected = policy(torch.from_numpy(seen), torch.from_numpy(noise)).numpy()
    assert np.allclose(served.sample(seen, np.random.default_rng(7)), expected, atol=1e-4)


def test_large_weights_are_stored_in_half_precision() -> None:
    policy = build_policy(tiny_spec(kind="mlp", width=512))
    numbers = sum(parameter.numel() for parameter in policy.parameters())
    assert len(export_policy(policy)) < 2.1 * numbers


def _ideal_denoiser(target: torch.Tensor, process: Flow | Diffusion):  # type: ignore[no-untyped-def]
    """A denoiser that knows the one chunk there is."""

    def flow(chunk: torch.Tensor, time: torch.Tensor, condition: torch.Tensor) -> torch.Tensor:
        return (target - chunk) / (1 - time[:, None, None])

    def epsilon(chunk: torch.Tensor, time: torch.Tensor, condition: torch.Tensor) -> torch.Tensor:
        assert isinstance(process, Diffusion)
        alpha = process.alphas[round(float(time[0]) * process.train_steps)]
        return (chunk - alpha.sqrt() * target) / (1 - alpha).sqrt()

    return flow if isinstance(process, Flow) else epsilon


@pytest.mark.parametrize(
    "process", [Flow(4), Diffusion(36, 36, fresh_noise=False), Diffusion(36, 6, fresh_noise=False)]
)
def test_sampling_with_a_perfect_denoiser_arrives_at_the_data(process: Flow | Diffusion) -> None:
    target = torch.rand(2, 8, 5) * 2 - 1
    noise = torch.randn(2, 1, 8, 5)
    sampled = process.sample(_ideal_denoiser(target, process), torch.zeros(2, 4), noise)
    assert torch.allclose(sampled, target, atol=1e-3)


def test_fewer_sampling_steps_use_times_of_the_schedule_that_was_trained() -> None:
    whole, short = Diffusion(36, 36, fresh_noise=False), Diffusion(36, 4, fresh_noise=False)
    assert torch.equal(whole.alphas, short.alphas)
    assert whole.alphas[-1] < 0.01 < 0.99 < whole.alphas[0]


def test_diffusion_tells_two_ways_apart_where_regression_takes_the_middle() -> None:
    """Half of the demonstrations go left, half right: a sample must go one way, the mean goes neither."""
    torch.manual_seed(0)
    spec = tiny_spec(layout="official-v1", obs_horizon=1, horizon=1, execute=1, width=32, depth=2, sample_steps=8)
    sideways = torch.where(torch.rand(4096, 1, 1) < 0.5, -1.0, 1.0).expand(-1, 1, 5).contiguous()
    observation = torch.zeros(4096, 1, spec.features)
    outcomes = {}
    for kind in ("dp", "mlp"):
        policy = build_policy(spec.model_copy(update={"kind": kind}))
        optimiser = torch.optim.Adam(policy.parameters(), lr=3e-3)
        for step in range(250):
            rows = slice(step % 16 * 256, step % 16 * 256 + 256)
            optimiser.zero_grad()
            policy.loss(observation[rows], sideways[rows]).mean().backward()  # type: ignore[no-untyped-call]
            optimiser.step()
        with torch.inference_mode():
            outcomes[kind] = policy(observation[:200], torch.randn(200, 1, 1, 5))[:, 0, 2]
    assert outcomes["dp"].abs().mean() > 0.7 and 40 < (outcomes["dp"] > 0).sum() < 160
    assert outcomes["mlp"].abs().mean() < 0.3


def test_it_does_not_matter_in_which_slot_an_item_stands() -> None:
    torch.manual_seed(0)
    spec = tiny_spec(denoiser="items")
    policy = build_policy(spec).eval()
    policy.fit_normaliser(torch.randn(spec.features), torch.rand(spec.features) + 0.5)
    seen, noise = torch.randn(4, 2, spec.features), torch.randn(4, 1, 8, 5)
    slots = torch.tensor(ITEM_COLUMNS)
    exchanged = seen.clone()
    exchanged[..., slots] = seen[..., slots[[3, 1, 2, 0, 6, 5, 4]]]
    less = seen.clone()
    less[..., slots[2]] = 0.0
    with torch.inference_mode():
        before, after, without = (policy(one, noise) for one in (seen, exchanged, less))
    assert torch.allclose(before, after, atol=1e-5)
    assert not torch.allclose(before, without, atol=1e-3)


def test_an_item_looks_the_same_to_the_normaliser_in_every_slot() -> None:
    """Half of the rows have an item in slot 0, the others in slot 1: together they are one distribution."""
    random, slots = torch.Generator().manual_seed(0), torch.tensor(ITEM_COLUMNS)
    rows = torch.randn(2000, tiny_spec().features, generator=random)
    mean, deviation = alike_for_items(rows.mean(dim=0), rows.std(dim=0))
    everything = rows[:, slots].flatten(0, 1)  # of all slots
    assert torch.allclose(mean[slots], everything.mean(dim=0).expand(7, -1), atol=1e-5)
    assert torch.allclose(deviation[slots], everything.std(dim=0).expand(7, -1), atol=1e-3)
    untouched = torch.ones(rows.shape[1], dtype=torch.bool)
    untouched[slots.flatten()] = False
    assert torch.equal(mean[untouched], rows.mean(dim=0)[untouched])


def test_a_card_names_the_first_of_more_maps_than_it_has_room_for() -> None:
    own = [f"Own{number:03d}" for number in range(MOST_MAPS + 10)]
    assert card_maps(own[:MOST_MAPS]) == own[:MOST_MAPS]
    assert card_maps(reversed(own)) == [*own[:MOST_MAPS], OTHER_MAPS]
    many = card_maps([*own, "generated:awareness:20000", "generated:awareness:20001"])
    assert many == [*own[:MOST_MAPS], "generated", OTHER_MAPS] == card_maps(many), "also when it is trained on"
    assert card_maps(["Yard", OTHER_MAPS, "aisle"]) == ["Yard", "aisle", OTHER_MAPS]
