"""Laws of the kinematics in Python, on arms of several families."""
import subprocess
import unittest

import numpy as np
import polyarm
from support import COMMAND, EXAMPLES

ARMS = ["universal_robots/ur5e", "fanuc/lr_mate_200id", "abb/irb_120", "franka/fer_panda", "demo/r6bot"]


def random_states(arm, count, seed=1):
    low, high = np.maximum(arm.lower, -3), np.minimum(arm.upper, 3)
    return np.random.default_rng(seed).uniform(low, high, (count, arm.joints))


class Kinematics(unittest.TestCase):
    def test_a_solution_reaches_its_pose_and_keeps_the_limits(self):
        for name in ARMS:
            with self.subTest(name):
                arm = polyarm.Robot(name)
                q = random_states(arm, 50)
                poses = arm.fk(q)
                found = arm.ik(poses, seed=q)
                self.assertFalse(np.isnan(found).any())
                np.testing.assert_allclose(arm.fk(found), poses, atol=1e-8)
                self.assertTrue((found >= arm.lower - 1e-9).all() and (found <= arm.upper + 1e-9).all())

    def test_many_states_give_the_same_as_one_at_a_time(self):
        arm = polyarm.Robot("universal_robots/ur5e")
        q = random_states(arm, 24).reshape(2, 3, 4, 6)
        self.assertEqual(arm.fk(q).shape, (2, 3, 4, 4, 4))
        self.assertEqual(arm.jacobian(q).shape, (2, 3, 4, 6, 6))
        np.testing.assert_array_equal(arm.fk(q)[1, 2, 3], arm.fk(q[1, 2, 3]))
        np.testing.assert_array_equal(arm.jacobian(q)[1, 0, 2], arm.jacobian(q[1, 0, 2]))
        np.testing.assert_allclose(arm.ik(arm.fk(q))[0, 1, 2], arm.ik(arm.fk(q[0, 1, 2])), atol=1e-9)
        self.assertEqual(arm.fk(np.empty((0, 6))).shape, (0, 4, 4))

    def test_the_jacobian_is_the_derivative_of_the_pose(self):
        arm = polyarm.Robot("abb/irb_120")
        h = 1e-6
        for q in random_states(arm, 5):
            J = arm.jacobian(q)
            for j in range(arm.joints):
                step = np.zeros(arm.joints)
                step[j] = h
                plus, minus, here = arm.fk(q + step), arm.fk(q - step), arm.fk(q)
                np.testing.assert_allclose((plus - minus)[:3, 3] / (2 * h), J[:3, j], atol=1e-8)
                spin = (plus - minus)[:3, :3] / (2 * h) @ here[:3, :3].T
                np.testing.assert_allclose([spin[2, 1], spin[0, 2], spin[1, 0]], J[3:, j], atol=1e-8)

    def test_the_frames_of_the_jacobian_agree(self):
        arm = polyarm.Robot("universal_robots/ur5e")
        q = random_states(arm, 1)[0]
        turn = arm.fk(q)[:3, :3]
        world, body = arm.jacobian(q), arm.jacobian(q, frame="body")
        np.testing.assert_allclose(turn @ body[:3], world[:3], atol=1e-12)
        np.testing.assert_allclose(turn @ body[3:], world[3:], atol=1e-12)

    def test_all_branches_reach_the_pose_and_are_distinct(self):
        arm = polyarm.Robot("universal_robots/ur5e")
        self.assertTrue(arm.ik_complete)
        pose = arm.fk(random_states(arm, 1, seed=4)[0])
        branches = arm.ik_all(pose)
        self.assertGreaterEqual(len(branches), 2)
        np.testing.assert_allclose(arm.fk(branches), np.broadcast_to(pose, (len(branches), 4, 4)), atol=1e-8)
        for i, branch in enumerate(branches):
            for other in branches[:i]:
                self.assertGreater(np.abs(branch - other).max(), 1e-3)

    def test_a_seed_that_solves_a_pose_is_the_answer(self):
        arm = polyarm.Robot("universal_robots/ur5e")
        q = random_states(arm, 20)
        np.testing.assert_allclose(arm.ik(arm.fk(q), seed=q), q, atol=1e-6)

    def test_pose_is_the_inverse_of_what_a_matrix_says(self):
        for rpy in np.random.default_rng(3).uniform(-3, 3, (20, 3)):
            made = polyarm.pose((1, 2, 3), rpy=rpy)
            np.testing.assert_allclose(made[:3, :3] @ made[:3, :3].T, np.eye(3), atol=1e-15)
        np.testing.assert_allclose(polyarm.pose(rpy=(0, 0, np.pi / 2)), polyarm.pose(quaternion=(0, 0, 1, 1)), atol=1e-15)

    def test_it_agrees_with_the_command(self):
        out = subprocess.run([COMMAND, "fk", "universal_robots/ur5e", "--joints", *"0.1 -1.2 1.3 -0.4 0.5 0.6".split(),
                              "--json"], capture_output=True, text=True, check=True).stdout
        position = __import__("json").loads(out)["xyz"]
        pose = polyarm.Robot("universal_robots/ur5e").fk([0.1, -1.2, 1.3, -0.4, 0.5, 0.6])
        np.testing.assert_allclose(pose[:3, 3], position, atol=1e-6)


class Mistakes(unittest.TestCase):
    def refused(self, code, call):
        with self.assertRaises(polyarm.Error) as caught:
            call()
        self.assertEqual(caught.exception.code, code)
        return caught.exception

    def test_errors_have_codes_and_advice(self):
        error = self.refused("unknown-robot", lambda: polyarm.Robot("universal_robots/ur55"))
        self.assertIn("did you mean", str(error))
        self.assertTrue(error.advice)
        self.assertEqual(error.problems[0]["severity"], "error")
        arm = polyarm.Robot("universal_robots/ur5e")
        self.assertIn("3.00 m", str(self.refused("unreachable", lambda: arm.ik(polyarm.pose((3, 0, 0))))))
        self.refused("bad-value", lambda: arm.jacobian(arm.home, frame="tool"))
        self.refused("unknown-link", lambda: polyarm.Robot("universal_robots/ur5e", tip="nowhere"))

    def test_numbers_that_are_no_pose_or_state_are_refused(self):
        arm = polyarm.Robot("universal_robots/ur5e")
        mirror, stretched, nan = np.diag([1.0, 1, -1, 1]), np.diag([2.0, 1, 1, 1]), np.full((4, 4), np.nan)
        for bad in (mirror, stretched, nan, np.zeros((4, 4))):
            self.refused("bad-pose", lambda: arm.ik(bad))
        for shape in ((5,), (7,), (2, 5), ()):
            with self.assertRaises(ValueError):
                arm.fk(np.zeros(shape))
        for shape in ((3, 3), (16,), (2, 8), (4, 8), (2, 4, 2), ()):  # some have as many numbers as poses
            for solve in (arm.ik, arm.ik_all):
                with self.assertRaisesRegex(ValueError, "a pose has 4 x 4 numbers"):
                    solve(np.resize(np.eye(4), shape))
        with self.assertRaisesRegex(ValueError, "one pose"):
            arm.ik_all(np.tile(np.eye(4), (2, 1, 1)))
        self.refused("wrong-size", lambda: arm.ik(np.tile(np.eye(4), (3, 1, 1)), seed=np.zeros((2, 6))))
        error = self.refused("malformed", lambda: arm.ik(polyarm.pose((0.4, 0, 0.3)), seed=np.full(6, np.nan)))
        self.assertEqual(str(error), "the seed contains NaN or infinity")
        error = self.refused("bad-pose", lambda: arm.ik(np.stack([np.eye(4), np.eye(4), nan])))
        self.assertIn("the matrix of pose 2 contains NaN", str(error))

    def test_a_pose_is_made_of_as_many_finite_numbers_as_it_has(self):
        for call, text in [(lambda: polyarm.pose((0.1,)), r"position has 3 numbers, not the shape \(1,\)"),
                           (lambda: polyarm.pose(0.1), "position has 3 numbers"),
                           (lambda: polyarm.pose((np.nan, 0, 0)), "position contains NaN"),
                           (lambda: polyarm.pose(rpy=(1, 2)), "rpy has 3 numbers"),
                           (lambda: polyarm.pose(rpy=(1, 2, np.inf)), "rpy contains NaN or infinity"),
                           (lambda: polyarm.pose(quaternion=(1, 0, 0)), "quaternion has 4 numbers"),
                           (lambda: polyarm.pose(quaternion=(0, 0, 0, 0)), "quaternion is zero")]:
            with self.assertRaisesRegex(ValueError, text):
                call()

    def test_a_robot_is_named_by_a_text_or_a_path(self):
        for name in (None, 3, ["universal_robots/ur5e"]):
            with self.assertRaises(TypeError):
                polyarm.Robot(name)

    def test_unreachable_poses_of_an_array_become_nan(self):
        arm = polyarm.Robot("universal_robots/ur5e")
        found = arm.ik(np.stack([arm.fk(arm.home), polyarm.pose((3, 0, 0))]))
        self.assertFalse(np.isnan(found[0]).any())
        self.assertTrue(np.isnan(found[1]).all())

    def test_a_description_file_is_a_robot(self):
        self.assertEqual(polyarm.Robot(EXAMPLES / "r6bot/r6bot.urdf").joint_names, [f"joint_{i}" for i in range(1, 7)])


if __name__ == "__main__":
    unittest.main()
