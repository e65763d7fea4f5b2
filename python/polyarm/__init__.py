"""Polyarm in Python: robots, kinematics, timing, and cells in lock-step.

    import polyarm
    arm = polyarm.Robot("universal_robots/ur5e")
    q = arm.ik(polyarm.pose((0.4, 0, 0.3), rpy=(3.1416, 0, 0)))

Metres, radians, seconds; poses are 4 x 4 matrices in the world. `polyarm.client` controls a cell that runs elsewhere.
The pages: docs/python.md.
"""
import importlib as _importlib

from .errors import Error

# Imported when they are used: they need the compiled module and NumPy, which polyarm.client does not.
_MODULES = {"Cell": "cell", "Motion": "motion", "state_to_state": "motion", "through_waypoints": "motion", "Robot": "robot",
            "Saved": "cell", "pose": "robot", "robots": "robot", "Surroundings": "surroundings", "Way": "surroundings"}

__all__ = ["Cell", "Error", "Motion", "Robot", "Saved", "Surroundings", "Way", "pose", "robots", "state_to_state",
           "through_waypoints"]


def __getattr__(name):
    if name == "__version__":
        value = _importlib.import_module("._compiled", __name__)._polyarm.version
    elif name in _MODULES:
        value = getattr(_importlib.import_module("." + _MODULES[name], __name__), name)
    elif name in _MODULES.values():
        return _importlib.import_module("." + name, __name__)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__():
    return sorted({*globals(), *_MODULES, "__version__"})
