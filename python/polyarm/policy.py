"""A policy moves a robot: a Python function that turns observations into actions at its own rate.

    from polyarm.policy import run_policy
    run_policy(cell, lambda observation: network(observation["observation.state"]), robot="arm", rate=30, seconds=20)

The actions are positions of joints. Between them the way is interpolated, and every target goes through the cell's limits,
workspace and guards. A policy that fails, is silent or gives anything but finite numbers moves nothing: the robot stops.
"""
import asyncio
import collections
import concurrent.futures
import contextlib
import math

import numpy as np

from .errors import Error
from .record import joints_of, running_joints

__all__ = ["ActionQueue", "PolicyFailed", "replay", "run_policy", "run_policy_on"]

_SENT_EVERY = 0.01  # s, of cell time or of the clock
_ARRIVES = 0.25  # s after its time for which the last action stays the target, so that the robot gets there
_MOST_ACTIONS = 10_000


class PolicyFailed(RuntimeError):
    """The policy has failed; the robot was told nothing more, and stops."""


class ActionQueue:
    """Actions with their times, and the way between them. A chunk replaces what is later than its first action."""

    def __init__(self, start, time, joints):
        self._actions = collections.deque([(time, np.asarray(start, float))])
        self._joints = joints

    def add(self, actions, time, rate):
        """One action or a chunk (actions x joints), the first for `time`. Raises PolicyFailed for anything else."""
        try:
            chunk = np.atleast_2d(np.asarray(actions, float))
        except (TypeError, ValueError) as error:
            raise PolicyFailed(f"the policy gave no numbers: {error}") from None
        if chunk.ndim != 2 or chunk.shape[1] != self._joints or not 0 < len(chunk) <= _MOST_ACTIONS:
            raise PolicyFailed(f"the policy gave an array of shape {np.shape(actions)}, not one value for each of "
                               f"{self._joints} joints")
        if not np.isfinite(chunk).all():
            raise PolicyFailed("the policy gave a value that is no finite number")
        while len(self._actions) > 1 and self._actions[-1][0] >= time - 1e-9:
            self._actions.pop()
        self._actions.extend((time + k / rate, action) for k, action in enumerate(chunk))

    def at(self, time):
        """The way at this time; None when the last action is over."""
        while len(self._actions) > 1 and self._actions[1][0] <= time:
            self._actions.popleft()
        begun, action = self._actions[0]
        if len(self._actions) == 1:
            return action if time <= begun + _ARRIVES else None
        ends, following = self._actions[1]
        share = min(max((time - begun) / (ends - begun), 0.0), 1.0) if ends > begun else 1.0
        return action + share * (following - action)


def _observation(states, names, joints, task):
    return {"observation.state": joints, "task": task, "states": dict(zip(names, states))}


def run_policy(cell, policy, robot="arm", rate=30.0, seconds=10.0, task="", speed=1.0, until=None):
    """Runs a policy on a Cell in lock-step for `seconds`; the number of observations that it got.

    `policy`: a function of an observation: {"observation.state": positions of the joints, "task": text, "states": every
    value by name}. It gives one action (a position for each joint), a chunk of actions at `rate`, or None: nothing new. An
    action is for the time of the next observation. Raises PolicyFailed if it fails, and Error if the cell refuses a
    target; the robot stops in both cases.
    """
    _check_times(rate, seconds)
    names = joints_of(cell, robot)
    short = [name.split("/")[-2] for name in names]
    columns = [cell.state_names.index(name) for name in names]
    queue, session, calls = None, None, 0
    start = due = cell.time
    try:
        while cell.time < start + seconds - 1e-9 and not (until and until()):
            now = cell.time
            if now >= due - 1e-9:
                states = cell.states()
                if queue is None:
                    queue = ActionQueue(states[columns], now, len(names))
                given = _called(policy, _observation(states, cell.state_names, states[columns], task))
                if given is not None:
                    queue.add(given, now + 1 / rate, rate)
                calls, due = calls + 1, due + 1 / rate
            target = queue.at(now)
            if target is not None:
                session = _send(cell, robot, short, target, speed, session)
            if cell.time < now + _SENT_EVERY:
                cell.run(now + _SENT_EVERY - cell.time)
    except BaseException:
        if session is not None:
            with contextlib.suppress(Error):  # the first error is the one to know
                cell.ask("jog", robot=robot, session=session, end=True)
        raise
    if session is not None:
        cell.ask("jog", robot=robot, session=session, end=True)
    return calls


def _check_times(rate, seconds):
    """Infinite seconds are a time, for `until`."""
    if not 0 < rate <= 1000:
        raise ValueError(f"a rate of {rate} observations per second: it must be above 0 and at most 1000")
    if not seconds >= 0:
        raise ValueError(f"seconds is {seconds}; it must be 0 or more")


def _send(cell, robot, short, target, speed, session):
    given = {} if session is None else {"session": session}
    joints = {name: float(value) for name, value in zip(short, target)}
    return cell.ask("target", robot=robot, joints=joints, hold=0.1, speed=speed, **given)["session"]


def _called(policy, observation):
    try:
        return policy(observation)
    except Exception as error:
        raise PolicyFailed(f"the policy failed: {type(error).__name__}: {error}") from error


async def run_policy_on(client, policy, robot="arm", rate=30.0, seconds=10.0, task="", speed=1.0, until=None):
    """The same on a running cell (polyarm.client). The policy runs in a thread of its own: while it thinks, the actions
    that are left are carried out, and after the last of them the robot stops. Needs control (session_take()) at the
    pendant's port; the local socket needs none.
    """
    _check_times(rate, seconds)
    names = await running_joints(client, robot)
    short = [name.split("/")[-2] for name in names]
    loop = asyncio.get_running_loop()
    queue, session, calls, thinking = None, None, 0, None
    start = due = loop.time()
    thread = concurrent.futures.ThreadPoolExecutor(1)
    try:
        while loop.time() < start + seconds and not (until and until()):
            now = loop.time()
            if thinking is not None and thinking.done():
                given, thinking = thinking.result(), None
                if given is not None:
                    queue.add(given, max(due, now), rate)
            if thinking is None and now >= due:
                values = {i["name"]: math.nan if i["value"] is None else i["value"]
                          for i in (await client.ask("interfaces"))["states"]}
                joints = np.array([values[name] for name in names], float)
                if queue is None:
                    queue = ActionQueue(joints, now, len(names))
                thinking = loop.run_in_executor(
                    thread, _called, policy, _observation(list(values.values()), list(values), joints, task))
                calls, due = calls + 1, max(due + 1 / rate, now)
            target = queue.at(loop.time())
            if target is not None:
                session = await _send_to(client, robot, short, target, speed, session)
            await asyncio.sleep(max(0.0, now + _SENT_EVERY - loop.time()))
    finally:
        thread.shutdown(wait=False, cancel_futures=True)  # a policy that hangs does not hold the robot's stop up
        if session is not None:
            await client.ask("jog", robot=robot, session=session, end=True)
    return calls


async def _send_to(client, robot, short, target, speed, session):
    given = {} if session is None else {"session": session}
    joints = {name: float(value) for name, value in zip(short, target)}
    try:
        return (await client.ask("target", robot=robot, joints=joints, hold=0.1, speed=speed, **given))["session"]
    except Error as error:
        if error.code != "session-over" or session is None:
            raise
        raise PolicyFailed("something stopped the robot; begin again") from error


def replay(episodes, episode=0):
    """A policy that repeats the actions of a recorded episode, one at each call; after the last one it is silent."""
    actions = iter(episodes.read(episode)["action"])
    return lambda observation: next(actions, None)
