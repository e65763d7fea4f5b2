"""A robot among the obstacles of a scene: contacts, distances, ways around them."""
import numpy as np

from ._compiled import _polyarm
from .motion import Motion, through_waypoints


class Way:
    """A way around obstacles: straight lines in joint space between `waypoints`, every state of them proven free."""

    def __init__(self, waypoints, radii):
        self.waypoints, self.radii = np.array(waypoints), np.array(radii)

    def timed(self, velocity, acceleration, jerk) -> Motion:
        """The fastest motion along it, with its corners rounded as far as that is proven free."""
        return through_waypoints(self.waypoints, velocity, acceleration, jerk, radius=self.radii)


class Surroundings:
    """A robot at the world's origin, without a tool, in the world of a scene file. One thread at a time."""

    def __init__(self, robot, scene="", clearance=0.0):
        """`robot`: a Robot. `scene`: a scene.yaml; empty: only the robot itself. `clearance`: m that must stay between robot
        and world. Raises Error."""
        self._robot = robot
        self._world = _polyarm.Surroundings(robot._robot, str(scene), float(clearance))

    warnings = property(lambda self: self._world.warnings, doc="Bodies that are unknown, and pairs that are not checked.")

    def touches(self, q):
        """True where a state touches the world or itself: shape (...) for states of shape (..., joints)."""
        rows, shape = self._robot._rows(q)
        touching = self._world.touches(rows).reshape(shape)
        return touching if shape else bool(touching)

    def nearest(self, q):
        """The two bodies that are nearest, and their distance in m; negative: how deep they overlap."""
        return self._world.nearest(self._robot._rows(q)[0])

    def plan(self, start, goal, seed=1, most_samples=50_000):
        """A Way from a joint state to another, to any of several (one per row), or to a pose (4 x 4). The same arguments
        give the same way. Raises Error: "no-way", "start-in-contact", "goal-in-contact", or why a pose is out of reach."""
        start, _ = self._robot._rows(start)
        goal = np.asarray(goal, float)
        matrix = goal.shape == (4, 4)  # of an arm with four joints, these may be four goals
        if matrix and (self._robot.joints != 4 or np.array_equal(goal[3], (0, 0, 0, 1))):
            goals = np.array(self._world.goals_for(goal.reshape((1, 4, 4)), start))
            if len(goals) == 0:
                goals = self._robot.ik(goal, start[0])[np.newaxis]  # raises, and says why
        else:
            goals, _ = self._robot._rows(goal)
        return Way(*self._world.plan(start, goals, seed, most_samples))
