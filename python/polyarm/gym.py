"""A cell as an environment of reinforcement learning, with gymnasium's interface. gymnasium itself is used where it is
installed, and is not needed.

    from polyarm.gym import CellEnv
    env = CellEnv("my_cell", controller="forward", observed=["arm/elbow_joint/position"], reward=my_reward)
"""
import numpy as np

from .cell import Cell
from .errors import Error

try:
    import gymnasium
    _Base = gymnasium.Env
    _Box = gymnasium.spaces.Box
except ImportError:
    gymnasium = None
    _Base = object

    class _Box:
        """The part of gymnasium.spaces.Box that an environment and its user need."""

        def __init__(self, low, high, dtype=np.float64, seed=None):
            self.low, self.high = np.asarray(low, dtype), np.asarray(high, dtype)
            self.shape, self.dtype = self.low.shape, np.dtype(dtype)
            self._random = np.random.default_rng(seed)

        def seed(self, seed=None):
            self._random = np.random.default_rng(seed)

        def sample(self):
            low, high = np.clip(self.low, -1e3, None), np.clip(self.high, None, 1e3)
            return self._random.uniform(low, high).astype(self.dtype)

        def contains(self, x):
            x = np.asarray(x)
            return x.shape == self.shape and bool(np.all(x >= self.low) and np.all(x <= self.high))


class CellEnv(_Base):
    """One arm or machine of a cell, commanded through a forward controller.

    An action has a value for each command of the controller; it is sent through the controller and the command limits, as
    every message. An observation has the values of the interfaces `observed`. One step is `cycles` of the control loop. An
    episode is terminated by a failure of the cell (a contact, a limit), and truncated after `steps`.
    """

    metadata = {"render_modes": []}

    def __init__(self, cell, controller, observed, low, high, reward=None, cycles=20, steps=500, **cell_options):
        """`cell`: a path, as for Cell, or a Cell. `reward`: a function of (observation, action, env)."""
        self.cell = cell if isinstance(cell, Cell) else Cell(cell, **cell_options)
        self._controller, self._reward = controller, reward or (lambda observation, action, env: 0.0)
        names = self.cell.state_names
        self._columns = [Cell._index(names, name) for name in observed]
        low, high = np.asarray(low, float), np.asarray(high, float)
        if low.ndim != 1 or low.shape != high.shape or not (low <= high).all():
            raise ValueError(f"low and high have one value for each command, low <= high; not {low} and {high}")
        self.action_space = _Box(low, high, dtype=np.float64)
        many = np.full(len(self._columns), np.inf)
        self.observation_space = _Box(-many, many, dtype=np.float64)
        self._cycles, self._steps, self._taken = cycles, steps, 0

    def reset(self, *, seed=None, options=None):
        """The cell anew. Returns the observation and an empty dict. `seed`: of env.np_random; None: it goes on."""
        if gymnasium is not None:
            super().reset(seed=seed)
        elif seed is not None or not hasattr(self, "np_random"):
            self.np_random = np.random.default_rng(seed)
        self.cell.reset()
        self._taken = 0
        return self._observation(), {}

    def step(self, action):
        """(observation, reward, terminated, truncated, info); `info["error"]` is the code of a failure. An action of another
        shape, or with NaN, is a ValueError: the program is wrong, not the robot."""
        action = np.asarray(action, float)
        if action.shape != self.action_space.shape:
            raise ValueError(f"an action has the shape {self.action_space.shape}, not {action.shape}")
        if np.isnan(action).any():
            raise ValueError("an action contains NaN")
        action = np.clip(action, self.action_space.low, self.action_space.high)
        info = {}
        try:
            self.cell.send(self._controller, action)
            self.cell.step(self._cycles)
        except Error as error:
            info = {"error": error.code, "text": str(error)}
        self._taken += 1
        observation = self._observation()
        reward = float(self._reward(observation, action, self))
        return observation, reward, bool(info), self._taken >= self._steps and not info, info

    def close(self):
        self.cell.close()

    def _observation(self):
        return self.cell.states()[self._columns]
