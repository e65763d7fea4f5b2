"""Policies move robots, and robots are recorded: in cells in lock-step, and in one that runs."""
import asyncio
import contextlib
import io
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest
import unittest.mock

import numpy as np
import polyarm
from polyarm import episodes as episodes_module
from polyarm.client import connect
from polyarm.episodes import DataSet
from polyarm.policy import ActionQueue, PolicyFailed, replay, run_policy, run_policy_on
from polyarm.record import features_of, joints_of, record, record_running, running_joints
from support import COMMAND, EXAMPLES, forward_cell, wait_for_cell

FEATURES = {"observation.state": ["a", "b"], "action": ["a", "b"]}


class Policies(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp()) / "set"
        self.addCleanup(shutil.rmtree, self.folder.parent)

    def cell(self):
        cell = polyarm.Cell(forward_cell(self))
        self.addCleanup(cell.close)
        cell.step(10)
        return cell

    def test_a_policy_moves_the_robot_and_an_episode_repeats_it(self):
        cell = self.cell()
        names = joints_of(cell)
        goal = np.array([0.3, -0.2, 0.4, 0.1, 0.2, -0.3])
        columns = [cell.state_names.index(name) for name in names]

        def towards(observation):
            here = observation["observation.state"]
            return here + np.clip(goal - here, -0.03, 0.03)

        out = DataSet.create(self.folder, features_of(names), fps=20)
        self.assertGreater(run_policy(cell, towards, rate=20, seconds=3), 50)
        self.assertLess(np.abs(cell.states()[columns] - goal).max(), 0.02)
        begin = cell.states()[columns]
        commands = [cell.command_names.index(name) for name in names]
        way = [begin + 0.2 * np.sin(np.arange(40) / 40 * np.pi)[k] for k in range(40)]
        out.begin("wave")
        for action in way:
            out.add_frame({"observation.state": begin, "action": action})
        out.save()
        run_policy(cell, replay(out), rate=20, seconds=1.05)
        self.assertLess(np.abs(cell.commands()[commands] - (begin + 0.2)).max(), 0.02)
        run_policy(cell, replay(out), rate=20, seconds=2.5)
        self.assertLess(np.abs(cell.states()[columns] - way[-1]).max(), 0.02)

    def test_the_way_is_smooth_at_a_low_rate(self):
        cell = self.cell()
        commands = [cell.command_names.index(name) for name in joints_of(cell)]
        start, speeds = cell.time, []
        before = cell.commands()[commands]

        def watch():
            nonlocal before
            now = cell.commands()[commands]
            speeds.append((cell.time - start, float(np.abs(now - before).max())))
            before = now
            return False

        run_policy(cell, lambda o: np.full(6, 0.3 * (cell.time - start + 0.1)), rate=10, seconds=3, until=watch)
        steady = [speed for time, speed in speeds if 1.5 < time < 2.9]
        self.assertLess(max(steady), 2 * np.median(steady))
        self.assertGreater(min(steady), 0.3 * np.median(steady))

    def test_a_policy_that_fails_moves_nothing_more(self):
        for bad in (lambda o: 1 / 0, lambda o: np.full(6, np.nan), lambda o: [1, 2], lambda o: "go",
                    lambda o: [[0.1] * 6, [np.inf] * 6]):
            cell = self.cell()
            columns = [cell.state_names.index(name) for name in joints_of(cell)]
            before = cell.states()[columns]
            with self.assertRaises(PolicyFailed):
                run_policy(cell, bad, rate=20, seconds=1)
            cell.run(0.5)
            np.testing.assert_allclose(cell.states()[columns], before, atol=1e-9)

    def test_rates_and_times_that_are_none_are_refused(self):
        cell = self.cell()
        before = cell.time
        for rate in (0, -1, np.nan, np.inf):
            with self.assertRaisesRegex(ValueError, "observations per second"):
                run_policy(cell, lambda observation: None, rate=rate, seconds=1)
        for seconds in (-1, np.nan):
            with self.assertRaisesRegex(ValueError, "it must be 0 or more"):
                run_policy(cell, lambda observation: None, seconds=seconds)
        self.assertEqual(cell.time, before)

    def test_the_first_error_is_told_if_the_cell_fails_meanwhile(self):
        cell = self.cell()

        def fails(observation):
            cell.ask = unittest.mock.Mock(side_effect=polyarm.Error([{"code": "later", "what": "", "advice": ""}]))
            raise ValueError("mine")

        def at_second_call(observation, calls=[]):  # pylint: disable=dangerous-default-value
            calls.append(1)
            return observation["observation.state"] if len(calls) == 1 else fails(observation)

        with self.assertRaisesRegex(PolicyFailed, "mine"):
            run_policy(cell, at_second_call, rate=30, seconds=1)

    def test_a_policy_that_falls_silent_stops_the_robot(self):
        cell = self.cell()
        columns = [cell.state_names.index(name) for name in joints_of(cell)]
        calls = iter(range(1000))
        run_policy(cell, lambda o: o["observation.state"] + 0.05 if next(calls) < 10 else None, rate=20, seconds=1.5)
        cell.run(0.1)
        here = cell.states()[columns]
        cell.run(0.5)
        np.testing.assert_allclose(cell.states()[columns], here, atol=1e-6)

    def test_targets_beyond_the_limits_are_refused(self):
        cell = self.cell()
        with self.assertRaises(polyarm.Error) as refused:
            run_policy(cell, lambda o: np.full(6, 50.0), rate=20, seconds=1)
        self.assertEqual(refused.exception.code, "beyond-limits")

    def test_a_chunk_replaces_what_is_later(self):
        queue = ActionQueue([0.0], 0.0, 1)
        queue.add([[1.0], [2.0], [3.0]], 1.0, 1.0)
        self.assertAlmostEqual(queue.at(0.5)[0], 0.5)
        self.assertAlmostEqual(queue.at(1.5)[0], 1.5)
        queue.add([[0.0]], 2.0, 1.0)
        self.assertAlmostEqual(queue.at(1.75)[0], 0.25)
        self.assertAlmostEqual(queue.at(2.0)[0], 0.0)
        self.assertAlmostEqual(queue.at(2.2)[0], 0.0)
        self.assertIsNone(queue.at(2.3))

    def test_an_action_of_ones_own_must_be_a_frame(self):
        cell = self.cell()
        out = DataSet.create(self.folder, features_of(joints_of(cell)), fps=30)
        for action in (np.full(6, np.nan), 1.0, np.zeros(5)):
            with self.assertRaises(ValueError):
                record(cell, out, "t", seconds=0.1, action=lambda action=action: action)
        for seconds in (0, -1, np.nan):
            with self.assertRaisesRegex(ValueError, "has no frames"):
                record(cell, out, "t", seconds=seconds)
        self.assertEqual(len(DataSet.open(self.folder)), 0)

    def test_a_cell_is_recorded(self):
        cell = self.cell()
        out = DataSet.create(self.folder, features_of(joints_of(cell), tcp=True), fps=25, robot_type="r6bot")
        cell.send("forward", [0.2] * 6)
        self.assertEqual(record(cell, out, "Reach forward", seconds=1), 0)
        self.assertEqual(out.check(), [])
        table = out.read(0)
        self.assertEqual(table["action"].shape, (25, 6))
        np.testing.assert_allclose(table["observation.state"][-1], 0.2, atol=1e-3)
        pose = polyarm.Robot(EXAMPLES / "r6bot/r6bot.urdf").fk([0.2] * 6)
        np.testing.assert_allclose(table["observation.tcp"][-1][:3], pose[:3, 3], atol=1e-3)
        with self.assertRaises(polyarm.Error):
            record(cell, out, "Reach forward", robot="nobody")
        with self.assertRaises(ZeroDivisionError):
            record(cell, out, "Reach forward", until=lambda: 1 / 0)
        self.assertEqual((len(out), out.frames), (1, 0))


class Running(unittest.IsolatedAsyncioTestCase):
    """With a cell on the clock of this machine; no test depends on how fast that is."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "run").mkdir(mode=0o700)
        environment = unittest.mock.patch.dict(os.environ, XDG_RUNTIME_DIR=str(self.folder / "run"), HOME=str(self.folder))
        environment.start()
        self.addCleanup(environment.stop)
        shutil.copytree(forward_cell(self).parent, self.folder / "six")
        shutil.copy(EXAMPLES / "r6bot/r6bot.urdf", self.folder / "six")
        (self.folder / "six/cell.yaml").write_text((self.folder / "six/cell.yaml").read_text().replace(
            f"{EXAMPLES}/r6bot/", ""))
        self.cell = subprocess.Popen([COMMAND, "run", str(self.folder / "six")], cwd=self.folder, text=True,
                                     stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(self.cell.wait)
        self.addCleanup(self.cell.kill)
        wait_for_cell(self, self.cell, "six")

    async def positions(self, client):
        states = {state["name"]: state["value"] for state in (await client.ask("interfaces"))["states"]}
        return np.array([states[name] for name in await running_joints(client)])

    async def at_rest(self, client):
        """Waits until nothing moves; the positions."""
        before = await self.positions(client)
        while True:
            await asyncio.sleep(0.1)
            now = await self.positions(client)
            if np.abs(now - before).max() < 1e-9:
                return now
            before = now

    async def test_a_policy_moves_a_running_cell_and_its_failure_stops_it(self):
        async with await connect("six") as client:
            goal = np.full(6, 0.2)

            def towards(observation):
                here = observation["observation.state"]
                return [here + np.clip(goal - here, -0.02, 0.02), goal * 0.5 + here * 0.5]

            calls = await run_policy_on(client, towards, rate=20, seconds=60, until=lambda: self.near)
            self.assertGreater(calls, 1)
            there = await self.at_rest(client)
            self.assertGreater(there.min(), 0.15)

            def fails(observation):
                raise RuntimeError("out of memory")

            for bad in (fails, lambda observation: np.full(6, np.nan)):
                with self.assertRaises(PolicyFailed):
                    await run_policy_on(client, bad, rate=20, seconds=60)
                np.testing.assert_allclose(await self.at_rest(client), there, atol=1e-9)

    near = False

    async def asyncSetUp(self):
        async def watch():
            async with await connect("six") as client:
                while not self.near:
                    self.near = (await self.positions(client)).min() > 0.19
                    await asyncio.sleep(0.05)

        self.watching = asyncio.create_task(watch())
        self.addCleanup(self.watching.cancel)

    async def test_a_running_cell_is_recorded(self):
        async with await connect("six") as client:
            out = DataSet.create(self.folder / "set", features_of(await running_joints(client)), fps=5)
            self.assertEqual(await record_running(client, out, "Stand still", seconds=1), 0)
            self.assertEqual(out.check(), [])
            self.assertEqual(out.read(0)["action"].shape, (5, 6))
        done = await asyncio.to_thread(episodes_module.main, ["record", str(self.folder / "set"), "--cell", "six", "--task",
                                                             "Stand", "--seconds", "0.6"])
        self.assertEqual(done, 0)
        again = DataSet.open(self.folder / "set")
        self.assertEqual((len(again), again.check()), (2, []))

    async def test_the_command_continues_a_set_only_as_it_is(self):
        DataSet.create(self.folder / "other", FEATURES, fps=5)
        async with await connect("six") as client:
            DataSet.create(self.folder / "set", features_of(await running_joints(client)), fps=5)
        for name, more, said in (("other", [], "has other features than 'arm' of this cell"),
                                 ("set", ["--fps", "30"], "has 5 frames per second, not 30"),
                                 ("new", ["--fps", "0"], "0 frames per second")):
            output = io.StringIO()
            with contextlib.redirect_stdout(output):
                done = await asyncio.to_thread(episodes_module.main, ["record", str(self.folder / name), "--cell", "six",
                                                                     "--task", "x", "--seconds", "0.4", *more])
            self.assertEqual(done, 1)
            self.assertIn(said, output.getvalue())
        self.assertFalse((self.folder / "new").exists())


if __name__ == "__main__":
    unittest.main()
