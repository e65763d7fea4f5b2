"""Robots of the catalogue or of a description file, and their kinematics."""
import os

import numpy as np

from ._compiled import _polyarm
from .errors import Error


def robots():
    """The robots of the catalogue: dicts with name, maker, model, axes, reach_m, payload_kg and mass_kg."""
    return _polyarm.catalogue()


def pose(position=(0, 0, 0), rpy=None, quaternion=None):
    """A pose as a 4 x 4 matrix. `rpy`: roll, pitch, yaw about fixed axes, as in URDF; `quaternion`: x y z w."""
    if rpy is not None and quaternion is not None:
        raise ValueError("state rpy or quaternion")
    out = np.eye(4)
    out[:3, 3] = _numbers(position, 3, "position")
    if rpy is not None:
        rpy = _numbers(rpy, 3, "rpy")
        (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
        out[:3, :3] = [[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                       [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                       [-sp, cp * sr, cp * cr]]
    if quaternion is not None:
        q = _numbers(quaternion, 4, "quaternion")
        length = np.linalg.norm(q)
        if not length > 0:
            raise ValueError("quaternion is zero: it has no rotation")
        x, y, z, w = q / length
        out[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                       [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                       [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    return out


def _numbers(values, count, what):
    """Finite numbers; ValueError for anything else."""
    out = np.asarray(values, float)
    if out.shape != (count,):
        raise ValueError(f"{what} has {count} numbers, not the shape {out.shape}")
    if not np.isfinite(out).all():
        raise ValueError(f"{what} contains NaN or infinity")
    return out


class Robot:
    """An arm: its joints and the kinematics of its tool link.

    Every function takes one joint state, shape (joints,), or any number of them, shape (..., joints); results have the
    same leading shape. The functions release the interpreter's lock, so that threads run side by side.
    """

    def __init__(self, name, tip="", arguments=None):
        """`name`: MAKER/MODEL, a URDF, a xacro or a robot file. `tip`: the link that carries the tool. `arguments`: of
        the xacro. Raises Error."""
        self._robot = _polyarm.Robot(os.fspath(name), tip, {k: str(v) for k, v in (arguments or {}).items()})

    name = property(lambda self: self._robot.name)
    joint_names = property(lambda self: self._robot.joint_names)
    joints = property(lambda self: len(self._robot.joint_names), doc="The number of values of a joint state.")
    lower = property(lambda self: np.array(self._robot.lower), doc="Lower limits; -inf: none.")
    upper = property(lambda self: np.array(self._robot.upper), doc="Upper limits; inf: none.")
    velocity = property(lambda self: np.array(self._robot.velocity), doc="Velocity limits; NaN: not stated.")
    acceleration = property(lambda self: np.array(self._robot.acceleration), doc="NaN: not stated.")
    jerk = property(lambda self: np.array(self._robot.jerk), doc="NaN: not stated.")
    effort = property(lambda self: np.array(self._robot.effort), doc="Effort limits; NaN: not stated.")
    home = property(lambda self: np.array(self._robot.start), doc="The state in which a simulation starts.")
    named_states = property(lambda self: {k: np.array(v) for k, v in self._robot.named_states.items()})
    reach = property(lambda self: self._robot.reach, doc="The largest distance of the tool from the base, m.")
    ik_report = property(lambda self: self._robot.ik_report, doc="How poses are solved for this arm, and why.")
    ik_complete = property(lambda self: self._robot.ik_complete, doc="True: ik_all() finds every solution.")
    warnings = property(lambda self: self._robot.warnings, doc="What is doubtful in the description.")

    def __repr__(self):
        return f"<polyarm.Robot {self.name}: {self.joints} joints>"

    def fk(self, q):
        """The pose of the tool link: shape (..., 4, 4)."""
        rows, shape = self._rows(q)
        return self._robot.forward(rows).reshape(shape + (4, 4))

    def jacobian(self, q, frame="world"):
        """Velocity of the tool for each joint velocity: shape (..., 6, joints), linear rows first. `frame`: axes of the
        "world" at the tool, of the tool ("body"), or the "space" Jacobian."""
        rows, shape = self._rows(q)
        return self._robot.jacobian(rows, frame).reshape(shape + (6, self.joints))

    def ik(self, target, seed=None):
        """The joint state nearest to `seed` (home) that reaches `target`, exactly and within limits.

        One pose: raises Error ("unreachable", "limits", ...) with the reason. Many poses, shape (..., 4, 4): a row of
        NaN where there is no solution. `seed`: one state for all, or one for each.
        """
        targets, shape = self._poses(target)
        seeds, _ = self._rows(self.home if seed is None else seed)
        found, outcomes = self._robot.solve(targets, seeds)
        if shape == () and outcomes[0] != "solved":
            if not np.isfinite(seeds).all():
                code, reason = "malformed", "the seed contains NaN or infinity"
            else:
                code, reason = self._robot.explain(targets, seeds)
            raise Error([{"code": outcomes[0], "what": reason or code, "advice": "", "where": "", "severity": "error"}])
        return found.reshape(shape + (self.joints,))

    def ik_all(self, target, seed=None):
        """Every branch within limits that reaches one pose, nearest to `seed` first: shape (solutions, joints)."""
        targets, shape = self._poses(target)
        if shape != ():
            raise ValueError(f"ik_all takes one pose of 4 x 4 numbers, not the shape {np.shape(target)}")
        seeds, _ = self._rows(self.home if seed is None else seed)
        return self._robot.solve_all(targets, seeds)

    @staticmethod
    def _poses(target):
        target = np.asarray(target, float)
        if target.shape[-2:] != (4, 4):
            raise ValueError(f"a pose has 4 x 4 numbers, not the shape {target.shape}")
        return target.reshape((-1, 4, 4)), target.shape[:-2]

    def _rows(self, q):
        q = np.asarray(q, float)
        if q.ndim == 0 or q.shape[-1] != self.joints:
            raise ValueError(f"a joint state of {self.name} has {self.joints} values, not the shape {q.shape}")
        return q.reshape((-1, self.joints)), q.shape[:-1]
