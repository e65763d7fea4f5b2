"""Records what a robot does as episodes: from a cell in lock-step, or from one that runs elsewhere."""
import asyncio
import re

import numpy as np

from .errors import Error

__all__ = ["features_of", "joints_of", "record", "record_running"]


def _error(code, what, advice=""):
    return Error([{"code": code, "what": what, "advice": advice, "where": "", "severity": "error"}])


def _joints(state_names, command_names, robot):
    """The joints of a robot with a measured and a commanded position, in the order of the cell."""
    commands = set(command_names)
    found = [name for name in state_names if re.fullmatch(re.escape(robot) + r"/[^/]+/position", name) and name in commands]
    if not found:
        raise _error("unknown-robot", f"the cell has no robot '{robot}' with positions of joints",
                     "polyarm interfaces lists what it has")
    return found


def joints_of(cell, robot="arm"):
    """The names of the positions of a robot's joints, measured and commanded: "arm/elbow_joint/position"."""
    return _joints(cell.state_names, cell.command_names, robot)


_TCP = ["x", "y", "z", "qx", "qy", "qz", "qw"]


def features_of(names, observed=(), cameras=None, tcp=False):
    """The features of a data set for these joints. `observed`: further interfaces. `cameras`: {name: (height, width)}.
    `tcp`: also the pose of the TCP in the world, as position and quaternion."""
    short = [name.split("/")[-2] for name in names]
    out = {"observation.state": short, "action": short}
    if observed:
        out["observation.environment_state"] = list(observed)
    if tcp:
        out["observation.tcp"] = _TCP
    return out | {f"observation.images.{name}": size for name, size in (cameras or {}).items()}


def _tcp_of(answer):
    return np.array([*answer["position"], *answer["orientation"]], float)


def record(cell, episodes, task, robot="arm", seconds=10.0, observed=(), images=None, until=None, action=None):
    """Steps a Cell and records one episode of it; its number.

    The observation is the measured, the action the commanded position of each joint. `observed`: further interfaces.
    `images`: a function that gives {name: height x width x 3, uint8}. `until`: a function that ends the episode when it
    returns true. `action`: a function that gives the action instead. If anything fails, the episode is discarded.
    """
    names = joints_of(cell, robot)
    states = [cell.state_names.index(name) for name in names]
    commands = [cell.command_names.index(name) for name in names]
    more = [cell.state_names.index(name) for name in observed]
    _check_seconds(seconds)
    start, frame = cell.time, 0
    episodes.begin(task)
    try:
        while frame < seconds * episodes.fps and not (until and until()):
            while cell.time < start + frame / episodes.fps - 1e-9:
                cell.step(1)
            measured, commanded = cell.states(), cell.commands()
            if action is None:
                wanted = commanded[commands]
                wanted = np.where(np.isfinite(wanted), wanted, measured[states])  # nobody commands: it stays
            else:
                wanted = np.asarray(action(), float)
            values = {"observation.state": measured[states], "action": wanted}
            if more:
                values["observation.environment_state"] = measured[more]
            if "observation.tcp" in episodes.features:
                values["observation.tcp"] = _tcp_of(cell.ask("jog.state", robot=robot))
            for name, image in (images() if images else {}).items():
                values[f"observation.images.{name}"] = image
            episodes.add_frame(values)
            frame += 1
        return episodes.save()
    except BaseException:
        episodes.discard()
        raise


async def running_joints(client, robot="arm"):
    """joints_of() of a running cell."""
    interfaces = await client.ask("interfaces")
    return _joints([i["name"] for i in interfaces["states"]], [i["name"] for i in interfaces["commands"]], robot)


async def record_running(client, episodes, task, robot="arm", seconds=10.0, observed=(), images=None, until=None):
    """Records one episode of a running cell (polyarm.client); its number. Arguments as of record().

    Each frame asks the cell for its values. If a frame comes later than 1.5 frames and 0.1 s, the episode is discarded,
    because its times would be wrong.
    """
    _check_seconds(seconds)
    names = await running_joints(client, robot)
    loop = asyncio.get_running_loop()
    start, frame = loop.time(), 0
    episodes.begin(task)
    try:
        while frame < seconds * episodes.fps and not (until and until()):
            due = start + frame / episodes.fps
            await asyncio.sleep(max(0.0, due - loop.time()))
            interfaces = await client.ask("interfaces")
            if loop.time() - due > 1.5 / episodes.fps + 0.1:
                raise _error("too-slow", f"frame {frame} came {loop.time() - due:.2f} s late",
                             "record fewer frames per second, or on a machine with less load")
            states = {i["name"]: i["value"] for i in interfaces["states"]}
            commands = {i["name"]: i["value"] for i in interfaces["commands"]}
            measured = np.array([_number(states.get(name)) for name in names])
            commanded = np.array([_number(commands.get(name)) for name in names])
            values = {"observation.state": measured, "action": np.where(np.isfinite(commanded), commanded, measured)}
            if observed:
                values["observation.environment_state"] = np.array([_number(states.get(name)) for name in observed])
            if "observation.tcp" in episodes.features:
                values["observation.tcp"] = _tcp_of(await client.ask("jog.state", robot=robot))
            for name, image in (images() if images else {}).items():
                values[f"observation.images.{name}"] = image
            episodes.add_frame(values)
            frame += 1
        return episodes.save()
    except BaseException:
        episodes.discard()
        raise


def _check_seconds(seconds):
    """Infinite is a time, for `until`."""
    if not seconds > 0:
        raise ValueError(f"an episode of {seconds} s has no frames")


def _number(value):
    return float("nan") if value is None else float(value)
