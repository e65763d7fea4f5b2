"""The compiled module, which knows the installation that it belongs to."""
import os

from . import _polyarm


def _installation():
    """The folder with lib/polyarm and share/polyarm, or the build folder: seen from this file."""
    here = os.path.dirname(os.path.realpath(_polyarm.__file__))
    build = os.path.dirname(os.path.dirname(here))  # BUILD/python/polyarm
    prefix = os.path.dirname(os.path.dirname(build))  # PREFIX/lib/python3/dist-packages/polyarm
    return prefix if os.path.isdir(os.path.join(prefix, "lib", "polyarm")) else build


_polyarm.use_installation(_installation())
