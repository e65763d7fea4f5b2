"""Timing: the fastest motion within limits of velocity, acceleration and jerk."""
import numpy as np

from ._compiled import _polyarm


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
    radii = np.broadcast_to(np.asarray(radius, float), (len(waypoints),))
    limits = _limits(waypoints.shape[1], velocity, acceleration, jerk)
    return Motion(_polyarm.PathMotion(waypoints, np.ascontiguousarray(radii), limits, spline))


def _state(state):
    """Rows of position, velocity and acceleration."""
    parts = state if isinstance(state, tuple) and np.ndim(state[0]) > 0 else (state,)
    position = np.atleast_1d(np.asarray(parts[0], float))
    out = np.zeros((3, position.size))
    for row, part in zip(out, parts):
        row[:] = part
    return out


def _limits(joints, velocity, acceleration, jerk):
    return np.array([np.broadcast_to(np.asarray(limit, float), (joints,)) for limit in (velocity, acceleration, jerk)])
