"""One seat of the world as a Gymnasium environment; an agent plays the other seat.

Importing this package makes it known to Gymnasium: `gymnasium.make("MovingOut-v1", map=…, partner=…, seat=…)`. `import
movingout` does that as soon as Gymnasium is imported too; in another process,
`gymnasium.make("movingout.agents.environment:MovingOut-v1")` does it.
"""

from movingout.maps.extras import needs_extra

with needs_extra("env", "the environment for reinforcement learning"):
    from gymnasium.envs.registration import register, registry

ENV_ID = "MovingOut-v1"

if ENV_ID not in registry:
    register(ENV_ID, entry_point="movingout.agents.environment.seat_env:make_seat_env")
