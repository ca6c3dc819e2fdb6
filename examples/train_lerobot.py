"""A LeRobot policy trained from an export and saved so that it can take a seat.

movingout recordings export data/recordings --to lerobot --out data/lerobot
pip install -c constraints/lerobot.txt -e '.[export,video]' lerobot
python examples/train_lerobot.py data/lerobot act outputs/act 5000
movingout match --red lerobot:path=outputs/act --blue scripted --map HandOff
"""

import sys

import torch
from lerobot.configs.types import FeatureType
from lerobot.datasets.lerobot_dataset import LeRobotDataset, LeRobotDatasetMetadata
from lerobot.datasets.utils import dataset_to_policy_features
from lerobot.policies.act.configuration_act import ACTConfig
from lerobot.policies.diffusion.configuration_diffusion import DiffusionConfig
from lerobot.policies.factory import make_policy, make_pre_post_processors

CONFIGS = {
    "act": lambda: ACTConfig(chunk_size=16, n_action_steps=8, device="cpu", push_to_hub=False),
    "diffusion": lambda: DiffusionConfig(
        horizon=16,
        n_action_steps=8,
        down_dims=(64, 128, 256),
        crop_shape=(64, 64),
        num_inference_steps=10,
        device="cpu",
        push_to_hub=False,
    ),  # a small U-Net: LeRobot's own is too slow for ten decisions a second without a GPU
}


def main(folder: str, kind: str, out: str, steps: int) -> None:
    meta = LeRobotDatasetMetadata("local/moving-out", root=folder)
    config = CONFIGS[kind]()
    features = dataset_to_policy_features(meta.features)
    config.output_features = {"action": features.pop("action")}
    config.input_features = {name: one for name, one in features.items() if one.type is not FeatureType.REWARD}
    config.input_features = {name: one for name, one in config.input_features.items() if name.startswith("observation")}
    policy = make_policy(config, ds_meta=meta)
    before, after = make_pre_post_processors(config, dataset_stats=meta.stats)
    seconds = 1 / meta.fps
    times = {"action": [seconds * step for step in config.action_delta_indices]}
    if config.observation_delta_indices:
        times |= {name: [seconds * step for step in config.observation_delta_indices] for name in config.input_features}
    data = LeRobotDataset("local/moving-out", root=folder, delta_timestamps=times, video_backend="pyav")
    optimizer = torch.optim.AdamW(policy.parameters(), lr=1e-4)
    loader = torch.utils.data.DataLoader(data, batch_size=min(64, len(data)), shuffle=True, drop_last=True)
    done = 0
    while done < steps:
        for batch in loader:
            loss, _ = policy.forward(before(batch))
            loss.backward()
            optimizer.step()
            optimizer.zero_grad()
            done += 1
            if done >= steps:
                break
    print(f"{kind}: {', '.join(config.input_features)}; {done} steps, loss {loss.item():.3f}")
    for part in (policy, before, after):
        part.save_pretrained(out)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3], int(sys.argv[4])) if len(sys.argv) == 5 else sys.exit(__doc__)
