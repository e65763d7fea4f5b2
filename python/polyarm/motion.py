"""Timing: the fastest motion within limits of velocity, acceleration and jerk."""
import numpy as np

from ._compiled import _polyarm
from .errors import Error, problem as _problem


class Motion:
    """A motion over time, from state_to_state() or through_waypoints()."""

    def __init__(self, motion):
        self._motion = motion

    duration = property(lambda self: self._motion.duration, doc="Seconds.")
    joints = property(lambda self: self._motion.joints)

    def sample(self, t):
        """Position, velocity, acceleration and jerk at the times `t` (clamped): each of shape t.shape + (joints,)."""
        t = np.asarray(t, float)
        if not np.all(np.isfinite(t)):
            raise ValueError("a time is NaN or infinite")
        times = np.clip(t, 0, self.duration)
        return tuple(self._motion.sample(times.ravel()).reshape((4,) + t.shape + (self.joints,)))

    def __call__(self, t):
        """The positions at the times `t`."""
        return self.sample(t)[0]

    def __repr__(self):
        return f"<polyarm.Motion of {self.joints} joints, {self.duration:.3f} s>"


def state_to_state(start, target, velocity, acceleration, jerk, synchronization="time", minimum_duration=0.0):
    """The fastest motion between two states.

    A state is an array of positions (at rest) or a tuple (position, velocity[, acceleration]). Limits are numbers or
    arrays. `synchronization`: "time", all joints arrive together; "phase", on a straight line if possible; "none".
    Raises Error.
    """
    start, target = _state(start), _state(target)
    limits = _limits(start.shape[1], velocity, acceleration, jerk)
    return Motion(_polyarm.DirectMotion(start, target, limits, synchronization, minimum_duration))


def through_waypoints(waypoints, velocity, acceleration, jerk, radius=0.0, spline=False):
    """The fastest motion along straight lines in joint space through all waypoints, shape (points, joints).

    `radius`: how far from a waypoint the corner may be cut, in the norm of joint differences; one number, or one for
    each waypoint. With 0 the motion stops at each corner. `spline`: a natural cubic spline, without stops. Raises Error.
    """
    waypoints = np.atleast_2d(np.asarray(waypoints, float))
    if waypoints.ndim != 2:
        raise ValueError(f"waypoints have the shape (points, joints), not {waypoints.shape}")
    if len(waypoints) < 2 or waypoints.shape[1] == 0:
        raise Error([_problem("wrong-size", "a motion through waypoints needs two or more of them, each with a joint or more")])
    radii = np.broadcast_to(np.asarray(radius, float), (len(waypoints),))
    limits = _limits(waypoints.shape[1], velocity, acceleration, jerk)
    return Motion(_polyarm.PathMotion(waypoints, np.ascontiguousarray(radii), limits, spline))


def _state(state):
    """Rows of position, velocity and acceleration."""
    parts = state if isinstance(state, tuple) and np.ndim(state[0]) > 0 else (state,)
    position = np.atleast_1d(np.asarray(parts[0], float))
    if position.ndim != 1:
        raise ValueError(f"a state has one position for each joint, not the shape {position.shape}")
    if len(parts) > 3:
        raise ValueError("a state is positions, or a tuple of positions, velocities and accelerations")
    out = np.zeros((3, position.size))
    for row, part, name in zip(out, parts, ("positions", "velocities", "accelerations")):
        row[:] = _of_joints(part, position.size, name)
    return out


def _limits(joints, velocity, acceleration, jerk):
    """One row for each kind of limit. Raises Error with every limit that is missing or not above 0."""
    kinds = {"velocity": velocity, "acceleration": acceleration, "jerk": jerk}
    out = np.array([_of_joints(limit, joints, f"{kind} limits") for kind, limit in kinds.items()])
    wrong = [_problem("bad-limit" if np.isfinite(value) else "bad-number",
                      f"the {kind} limit of joint {j} is {value:g}",
                      "limits are finite and above 0; NaN in the limits of a Robot: its description does not state them")
             for kind, row in zip(kinds, out) for j, value in enumerate(row) if not 0 < value < np.inf]
    if wrong:
        raise Error(wrong)
    return out


def _of_joints(values, joints, what):
    values = np.asarray(values, float)
    if values.shape not in ((), (joints,)):
        raise ValueError(f"{what}: one number or one for each of {joints} joints, not the shape {values.shape}")
    return np.broadcast_to(values, (joints,))
