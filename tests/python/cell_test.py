"""Cells in lock-step: repeatable, several at once, told apart by their codes when they fail."""
import concurrent.futures
import multiprocessing
import os
import pickle
import signal
import threading
import unittest

import numpy as np
import polyarm
from polyarm.gym import CellEnv
from support import EXAMPLES, forward_cell

PICK = EXAMPLES / "pick_and_place"


def states_after(seconds):
    """In a process of its own."""
    with polyarm.Cell(PICK) as cell:
        cell.start_program()
        cell.run(seconds)
        return cell.states()


class Cells(unittest.TestCase):
    def cell(self, *arguments, **options):
        cell = polyarm.Cell(*arguments, **options)
        self.addCleanup(cell.close)
        return cell

    def test_time_goes_on_by_steps_alone(self):
        cell = self.cell(PICK)
        self.assertEqual(cell.time, 0)
        cell.step(250)
        self.assertAlmostEqual(cell.time, 250 * cell.period)
        cell.run(0.5)
        self.assertAlmostEqual(cell.time, 250 * cell.period + 0.5)
        with self.assertRaises(ValueError):
            cell.step(-1)
        for cycles in ("1.5", "nan", "inf"):
            with self.assertRaisesRegex(ValueError, cycles + " cycles: a whole number was expected"):
                cell.step(float(cycles))
        for seconds in (np.nan, np.inf):
            with self.assertRaisesRegex(ValueError, "it must be finite"):
                cell.run(seconds)

    def test_arguments_of_another_kind_are_refused(self):
        for path in (None, 5):
            with self.assertRaises(TypeError):
                polyarm.Cell(path)
        with self.assertRaisesRegex(TypeError, "answers is a list"):
            polyarm.Cell(PICK, answers="yes")
        cell = self.cell(PICK)
        for patience in (-1, np.nan, np.inf):
            with self.assertRaisesRegex(ValueError, "patience is"):
                cell.ask("program", patience=patience)
        with self.assertRaisesRegex(ValueError, "an argument of tags.set contains NaN"):
            cell.set_tag("Vacuum", np.nan)
        self.assertIn("tags", cell.ask("tags.list", id="mine"))  # id belongs to the cell
        with self.assertRaisesRegex(KeyError, "arm/elbow_joint/position"):
            cell.state("arm/elbow/position")

    def test_a_closed_cell_says_so(self):
        cell = self.cell(PICK)
        cell.close()
        for use in (cell.step, cell.states, lambda: cell.run(1), lambda: cell.time, lambda: cell.tag("Feed"), cell.reset):
            with self.assertRaises(polyarm.Error) as closed:
                use()
            self.assertEqual(closed.exception.code, "closed")
        cell.close()

    def test_a_waiting_program_moves_nothing(self):
        cell = self.cell(PICK)
        before = cell.state("arm/elbow_joint/position")
        cell.run(1)
        self.assertAlmostEqual(cell.state("arm/elbow_joint/position"), before, places=6)
        self.assertEqual(cell.ask("program")["state"], "ready")

    def test_the_program_runs_and_moves_the_parts(self):
        cell = self.cell(PICK)
        self.assertEqual(cell.run_program()["state"], "finished")
        self.assertEqual(cell.tag("FeederLeft"), 0)
        self.assertIn("line", {event.kind for event in cell.events()})
        self.assertEqual(cell.events(), [])

    def test_a_reset_repeats_the_run_bit_for_bit(self):
        cell = self.cell(PICK)
        runs = []
        for _ in range(2):
            cell.start_program()
            values = []
            for _ in range(40):
                cell.step(100)
                values.append(np.concatenate([cell.states(), cell.commands()]))
            runs.append(np.array(values))
            cell.reset()
            self.assertEqual(cell.time, 0)
        np.testing.assert_array_equal(runs[0], runs[1])
        self.assertGreater(np.nanmax(np.ptp(runs[0], axis=0)), 0.1)

    def test_cells_in_threads_do_not_disturb_each_other(self):
        def trace(_):
            with polyarm.Cell(PICK) as cell:
                cell.start_program()
                cell.run(3)
                return cell.states()

        with concurrent.futures.ThreadPoolExecutor(3) as pool:
            first, *others = pool.map(trace, range(3))
        for other in others:
            np.testing.assert_array_equal(first, other)

    def test_processes_share_the_folder_of_a_cell(self):
        with concurrent.futures.ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
            first, second = pool.map(states_after, [2.0, 2.0])
        np.testing.assert_array_equal(first, second)
        np.testing.assert_array_equal(first, states_after(2.0))

    def test_one_thread_reads_while_another_steps(self):
        cell = self.cell(PICK)
        cell.start_program()
        with concurrent.futures.ThreadPoolExecutor(1) as pool:
            stepping = pool.submit(cell.step, 2000)
            while not stepping.done():
                self.assertEqual(len(cell.states()), len(cell.state_names))
                cell.events()
            stepping.result()

    def test_another_thread_never_sees_half_a_cell(self):
        cell = self.cell(PICK)
        names, wrong, done = cell.state_names, [], threading.Event()

        def read():
            while not done.is_set():
                seen = (cell.state_names, len(cell.states()), len(cell.commands()), cell.loop_state, cell.finished, cell.period)
                if seen[:2] != (names, len(names)) or seen[3] != "running" or cell.time < 0 or cell.events() is None:
                    wrong.append(seen)

        readers = [threading.Thread(target=read) for _ in range(2)]
        for reader in readers:
            reader.start()
        for _ in range(30):
            cell.reset()
            cell.step(20)
            cell.ask("program")
        done.set()
        for reader in readers:
            reader.join()
        self.assertEqual(wrong, [])

    def test_a_saved_state_comes_back_bit_for_bit(self):
        cell = self.cell(PICK)
        cell.start_program()
        cell.run(2)
        cell.ask("control.override", percent=50)
        saved = pickle.loads(pickle.dumps(cell.save()))
        self.assertEqual(saved.time, cell.time)

        def rest(cell):
            cell.run(3)
            return np.concatenate([cell.states(), cell.commands()]), cell.tag("FeederLeft"), cell.time

        first = rest(cell)
        cell.restore(saved)
        self.assertEqual(cell.time, saved.time)
        again, other = rest(cell), self.cell(PICK)
        other.restore(saved)
        for now in (again, rest(other)):
            np.testing.assert_array_equal(now[0], first[0])
            self.assertEqual(now[1:], first[1:])
        cell.restore(saved)
        np.testing.assert_array_equal(cell.save()._states, saved._states)

    def test_a_state_of_another_cell_is_refused(self):
        saved = self.cell(PICK).save()
        with self.assertRaises(polyarm.Error) as caught:
            self.cell(PICK, robot="abb/irb_120").restore(saved)
        self.assertEqual(caught.exception.code, "not-repeatable")

    def test_a_copy_of_the_process_leaves_the_original_alone(self):
        cell = self.cell(PICK)
        cell.start_program()
        cell.run(1)
        folder = cell._folder
        reading, writing = os.pipe()
        child = os.fork()
        if child == 0:
            cell.run(1)
            os.write(writing, cell.states().tobytes())
            cell.close()
            os._exit(0)
        os.close(writing)
        with os.fdopen(reading, "rb") as file:
            ahead = np.frombuffer(file.read())
        os.waitpid(child, 0)
        self.assertTrue(os.path.isdir(folder))
        cell.run(1)
        np.testing.assert_array_equal(cell.states(), ahead)

    def test_ctrl_c_ends_a_long_run(self):
        cell = self.cell(forward_cell(self))

        def interrupt():
            while cell.time < 1:
                pass
            signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)

        with concurrent.futures.ThreadPoolExecutor(1) as pool:
            interrupting = pool.submit(interrupt)
            with self.assertRaises(KeyboardInterrupt):
                cell.step(50_000_000)
            interrupting.result()
        self.assertLess(cell.time, 50_000_000 * cell.period)

    def test_a_reset_that_fails_leaves_a_cell_that_says_so(self):
        path = forward_cell(self)
        cell = self.cell(path)
        path.write_text("polyarm: cell/1\nrobots: {arm: {model: nothing/nowhere}}\n")
        for call in (cell.reset, cell.step, cell.states, lambda: cell.time, lambda: cell.ask("program")):
            with self.assertRaises(polyarm.Error):
                call()

    def test_a_forward_controller_takes_numbers(self):
        cell = self.cell(forward_cell(self))
        cell.send("forward", [0.1, -0.2, 0.3, 0, 0, 0.05])
        cell.run(1)
        np.testing.assert_allclose([cell.state(f"arm/joint_{i}/position") for i in (1, 2, 3, 6)], [0.1, -0.2, 0.3, 0.05],
                                   atol=1e-6)
        self.assertAlmostEqual(cell.command("arm/joint_2/position"), -0.2)

    def test_tags_are_read_and_set(self):
        cell = self.cell(PICK)
        self.assertFalse(cell.tag("Vacuum"))
        cell.set_tag("Vacuum", True)
        cell.run(0.01)
        self.assertTrue(cell.tag("Vacuum"))

    def test_a_refused_request_has_its_code(self):
        cell = self.cell(PICK)
        for code, request, arguments in [("unknown-request", "nonsense", {}), ("unknown-controller", "control.unload", {"name": "x"})]:
            with self.assertRaises(polyarm.Error) as caught:
                cell.ask(request, **arguments)
            self.assertEqual(caught.exception.code, code)
        with self.assertRaises(KeyError):
            cell.state("arm/elbow/position")

    def test_a_request_that_goes_on_gives_its_first_answer(self):
        cell = self.cell("demo/r6bot")
        self.assertIn("position", cell.ask("watch", name="joint_states"))
        self.assertIn("position", cell.ask("watch", name="joint_states"))

    def test_a_cell_that_cannot_be_built_says_everything(self):
        with self.assertRaises(polyarm.Error) as caught:
            polyarm.Cell(PICK, robot="universal_robots/nothing")
        self.assertEqual(caught.exception.code, "unknown-robot")
        with self.assertRaises(polyarm.Error):
            polyarm.Cell("/nowhere")

    def test_runs_leave_nothing_in_the_cells_folder(self):
        before = sorted(PICK.rglob("*"))
        with polyarm.Cell(PICK) as cell:
            cell.start_program()
            cell.run(2)
        self.assertEqual(sorted(PICK.rglob("*")), before)


class Environment(unittest.TestCase):
    def env(self, **options):
        joints = [f"arm/joint_{i}/position" for i in range(1, 7)]
        env = CellEnv(forward_cell(self), "forward", joints, [-3] * 6, [3] * 6, **options)
        self.addCleanup(env.close)
        return env

    def test_an_episode_is_truncated_and_begins_anew(self):
        env = self.env(steps=3, reward=lambda observation, action, env: -np.abs(observation).sum())
        observation, info = env.reset(seed=1)
        self.assertEqual(info, {})
        for i in range(3):
            observation, reward, terminated, truncated, info = env.step(np.full(6, 0.01 * (i + 1)))
            self.assertTrue(env.observation_space.contains(observation))
            self.assertEqual((terminated, truncated), (False, i == 2))
        self.assertLess(reward, 0)
        again, _ = env.reset(seed=1)
        self.assertEqual(env.cell.time, 0)
        self.assertLess(np.abs(again).sum(), np.abs(observation).sum())

    def test_an_action_outside_its_space_is_clipped(self):
        env = self.env()
        env.reset()
        env.step(np.full(6, 1e9))
        self.assertLessEqual(np.nanmax(np.abs(env.cell.commands())), 3)

    def test_wrong_arguments_of_an_environment_are_errors_of_the_program(self):
        env = self.env()
        env.reset(seed=3)
        for action in (np.zeros(1), np.zeros((1, 6)), 0.0, np.full(6, np.nan)):
            with self.assertRaisesRegex(ValueError, "an action"):
                env.step(action)
        for low, high in (([0], [1, 2]), ([2, 2], [1, 1]), (0, 1)):
            with self.assertRaisesRegex(ValueError, "low and high"):
                CellEnv(env.cell, "forward", [], low, high)
        with self.assertRaisesRegex(KeyError, "there is no interface 'arm/joint_1/positon'; there are arm/joint_1/position"):
            CellEnv(env.cell, "forward", ["arm/joint_1/positon"], [0], [1])

    def test_randomness_goes_on_without_a_seed_and_repeats_with_one(self):
        env = self.env()
        draws = []
        for seed in (5, None, 5, None):
            env.reset(seed=seed)
            draws.append(env.np_random.random())
        self.assertEqual(draws[:2], draws[2:])
        self.assertNotEqual(draws[0], draws[1])

    def test_a_refusal_ends_the_episode_with_its_code(self):
        env = self.env()
        env.reset()
        env.cell.ask("control.state", name="forward", state="inactive")
        _, _, terminated, truncated, info = env.step(np.zeros(6))
        self.assertTrue(terminated)
        self.assertFalse(truncated)
        self.assertTrue(info["error"])


if __name__ == "__main__":
    unittest.main()
