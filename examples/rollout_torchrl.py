"""Rollouts of TorchRL that go on past the end of an episode: both seats, and one seat beside a partner.

pip install -c constraints/torchrl.txt -e '.[env]' torch==2.13.0 torchrl
python examples/rollout_torchrl.py
"""

from torchrl.envs import GymEnv, PettingZooWrapper

from movingout.world.env import MovingOutEnv

both_seats = PettingZooWrapper(MovingOutEnv("HandOff", limit_ticks=15))
rollout = both_seats.rollout(40, break_when_any_done=False)
print("both seats:", len(rollout), "steps,", int(rollout["next", "done"].sum()), "episodes ended")

one_seat = GymEnv("movingout.agents.environment:MovingOut-v1", partner="idle", limit_ticks=15)
rollout = one_seat.rollout(40, break_when_any_done=False)
print("one seat:", len(rollout), "steps,", int(rollout["next", "done"].sum()), "episodes ended")
