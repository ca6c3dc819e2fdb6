"""Every number of the simulated world, with unit and meaning.

They are those of the official environment (live-robotics-uva/movingout_env at 9d1bdc8), measured and
confirmed by replaying its trajectories to the bit. The engine must be pymunk 6.8.0 to 6.11.1: version 7
dropped a rule on which holding depends. The sizes of arena and robots, and by how much walls and goals
are larger than drawn, are in `maps.spec`. Units: arena units (u), seconds, radians, engine masses.
"""

# Time
TICK_SECONDS = 0.1
TICKS_PER_SECOND = round(1 / TICK_SECONDS)
TICK_MS = round(1000 * TICK_SECONDS)
HALF_TICK_SECONDS = TICK_SECONDS / 2  # a robot's command takes effect at the start of its half: blue's, then red's
SUB_STEPS = 20  # engine steps per tick
SUB_STEPS_PER_HALF = SUB_STEPS // 2
SUB_STEP_SECONDS = HALF_TICK_SECONDS / SUB_STEPS_PER_HALF  # the same float as the official (1 / 20) / 10
POSES_PER_TICK = 5  # poses per tick for smooth drawing; the last is the state after the tick
POSE_SECONDS = TICK_SECONDS / POSES_PER_TICK
LIMIT_TICKS = 500  # default length of an episode, as in the paper's evaluation
TUTORIAL_TICKS = 6000  # longest tutorial, for somebody who went away; most need a minute
MAX_TICKS = 3600 * TICKS_PER_SECOND  # longest episode: an hour
MAX_SEED = 2**53 - 1  # of an episode: the largest that every program reads from JSON as it is

# Engine
SOLVER_ITERATIONS = 10
COLLISION_SLOP = 0.001  # u; collision_bias and error_bias stay at the engine's defaults, to the bit

# Arena, walls, goals
ARENA_WALL_RADIUS = 1.0  # u, thick segments whose inner faces are the arena's edge
ARENA_WALL_FRICTION = 2.0
WALL_FRICTION = 0.8

# Robots
ROBOT_MASS = 1.0
ROBOT_FRICTION = 0.5
DRIVE_SPEED = 0.6  # u/s at distance 1
DRIVE_DEAD_ZONE = 0.01  # on |dx| + |dy|: shorter commands turn in place
DRIVE_MAX_FORCE = 1000.0
TURN_MAX_SPEED = 5.0  # rad/s
TURN_MAX_FORCE = 100.0
TURN_FIRST_ANGLE = 0.4  # rad; a free robot farther off its heading drives slowly while it turns
TURN_LIMIT = 2.0  # rad; the control angle is never farther from the body
SLOW_FACTOR = 0.1  # of the speed, while turning or while alone with a middle item
SLOW_TURN_DIVISOR = 100.0  # of the turn, while alone with a middle item
TOGETHER_TURN_DIVISOR = -10.0  # of the turn, while both hold one item (and the other way round)

# Two shapeless "eye" bodies on springs hang on each robot; they do move it.
EYE_MASS = 0.1
EYE_STIFFNESS = 0.1
EYE_DAMPING = 0.003
EYE_MAX_FORCE = 0.001

# Items and hands
ITEM_FRICTION = 0.4
REACH = 0.095  # u from the robot's centre to the probe point, along its heading
REACH_TOLERANCE = 0.04  # u, how near to the probe point an item's surface must be (strictly)
SMALL_MOMENT = 0.001  # moment of inertia of a small item while it is held
SOLO_MIDDLE_MASS = 0.4  # mass and moment of a middle item that one robot holds
SOLO_MIDDLE_MOMENT = 0.1
SHARED_MOMENT = 1.0  # moment of an item that both robots hold
STAR_GROUP = 1000  # first collision group of the stars' parts
