"""Polyarm in Python: robots, kinematics, timing, and cells in lock-step.

    import polyarm
    arm = polyarm.Robot("universal_robots/ur5e")
    q = arm.ik(polyarm.pose((0.4, 0, 0.3), rpy=(3.1416, 0, 0)))

Metres, radians, seconds; poses are 4 x 4 matrices in the world. `polyarm.client` controls a cell that runs elsewhere.
The pages: docs/python.md.
"""
import os as _os

from . import _polyarm
from .errors import Error


def _installation():
    """The folder with lib/polyarm and share/polyarm, or the build folder: seen from this file."""
    here = _os.path.dirname(_os.path.realpath(_polyarm.__file__))
    build = _os.path.dirname(_os.path.dirname(here))  # BUILD/python/polyarm
    prefix = _os.path.dirname(_os.path.dirname(build))  # PREFIX/lib/python3/dist-packages/polyarm
    return prefix if _os.path.isdir(_os.path.join(prefix, "lib", "polyarm")) else build


_polyarm.use_installation(_installation())
__version__ = _polyarm.version

from .cell import Cell  # noqa: E402  (needs the installation)
from .motion import Motion, state_to_state, through_waypoints  # noqa: E402
from .robot import Robot, pose, robots  # noqa: E402
from .surroundings import Surroundings, Way  # noqa: E402

__all__ = ["Cell", "Error", "Motion", "Robot", "Surroundings", "Way", "pose", "robots", "state_to_state",
           "through_waypoints"]
