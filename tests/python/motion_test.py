"""Laws of motions: they begin and end where asked, keep limits, and fit together."""
import unittest

import numpy as np
import polyarm

LIMITS = {"velocity": 2.0, "acceleration": 8.0, "jerk": 80.0}


def largest(values):
    return float(np.abs(values).max())


class Motions(unittest.TestCase):
    def keeps_limits(self, motion, limits=LIMITS):
        t = np.linspace(0, motion.duration, 2001)
        p, v, a, j = motion.sample(t)
        self.assertLessEqual(largest(v), limits["velocity"] * (1 + 1e-6))
        self.assertLessEqual(largest(a), limits["acceleration"] * (1 + 1e-6))
        self.assertLessEqual(largest(j), limits["jerk"] * (1 + 1e-6))
        dt = t[1] - t[0]
        np.testing.assert_allclose(np.diff(p, axis=0) / dt, (v[1:] + v[:-1]) / 2, atol=limits["jerk"] * dt**2)
        return p, v

    def test_from_state_to_state_within_limits(self):
        random = np.random.default_rng(5)
        for _ in range(20):
            start, target = random.uniform(-2, 2, (2, 6))
            speed = random.uniform(-0.5, 0.5, 6)
            for synchronization in ("time", "none"):
                motion = polyarm.state_to_state((start, speed), target, synchronization=synchronization, **LIMITS)
                p, v = self.keeps_limits(motion)
                np.testing.assert_allclose(p[0], start, atol=1e-12)
                np.testing.assert_allclose(v[0], speed, atol=1e-12)
                np.testing.assert_allclose(p[-1], target, atol=1e-9)
                np.testing.assert_allclose(v[-1], 0, atol=1e-9)

    def test_phase_is_a_straight_line(self):
        start, target = np.zeros(3), np.array([1.0, -0.5, 0.2])
        motion = polyarm.state_to_state(start, target, synchronization="phase", **LIMITS)
        p = motion(np.linspace(0, motion.duration, 50))
        np.testing.assert_allclose(p / target, np.broadcast_to(p[:, :1], p.shape), atol=1e-9)

    def test_one_joint_takes_the_time_of_the_formula(self):
        # Acceleration and speed limits are not reached: 4 pieces of constant jerk, each (d / 2 j)^(1/3) long.
        motion = polyarm.state_to_state([0.0], [0.001], velocity=10, acceleration=10, jerk=10)
        self.assertAlmostEqual(motion.duration, 4 * (0.001 / 20) ** (1 / 3), places=9)

    def test_minimum_duration_stretches(self):
        motion = polyarm.state_to_state([0.0], [1.0], minimum_duration=5, **LIMITS)
        self.assertAlmostEqual(motion.duration, 5)

    def test_waypoints_are_met_and_radii_save_time(self):
        points = np.array([[0, 0], [1, 0], [1, 1.0]])
        stopping = polyarm.through_waypoints(points, **LIMITS)
        rounded = polyarm.through_waypoints(points, radius=0.2, **LIMITS)
        spline = polyarm.through_waypoints(points, spline=True, **LIMITS)
        for motion in (stopping, rounded, spline):
            p, v = self.keeps_limits(motion)
            np.testing.assert_allclose(p[[0, -1]], points[[0, -1]], atol=1e-9)
            np.testing.assert_allclose(v[[0, -1]], 0, atol=1e-9)
        self.assertLess(rounded.duration, stopping.duration)
        t = np.linspace(0, stopping.duration, 5001)
        self.assertLess(np.linalg.norm(stopping(t) - points[1], axis=1).min(), 1e-3)
        closest = np.linalg.norm(rounded(np.linspace(0, rounded.duration, 5001)) - points[1], axis=1).min()
        self.assertTrue(0.01 < closest <= 0.2, closest)

    def test_limits_of_each_joint(self):
        slow = polyarm.state_to_state([0, 0], [1, 1], velocity=[2, 0.1], acceleration=8, jerk=80, synchronization="none")
        self.assertLessEqual(largest(slow.sample(np.linspace(0, slow.duration, 500))[1][:, 1]), 0.1 + 1e-9)

    def test_times_are_clamped_and_shapes_kept(self):
        motion = polyarm.state_to_state([0.0, 0], [1.0, 2], **LIMITS)
        self.assertEqual(motion(np.zeros((3, 4))).shape, (3, 4, 2))
        np.testing.assert_allclose(motion(1e9), [1, 2])
        np.testing.assert_allclose(motion(-1), [0, 0])

    def test_wrong_numbers_are_refused(self):
        for call, code in [
                (lambda: polyarm.state_to_state([0.0], [1.0], velocity=-1, acceleration=1, jerk=1), "bad-limit"),
                (lambda: polyarm.state_to_state([np.nan], [1.0], **LIMITS), "bad-number"),
                (lambda: polyarm.state_to_state([0.0], [1.0, 2], **LIMITS), "wrong-size"),
                (lambda: polyarm.state_to_state([0.0], ([1.0], [9.0]), **LIMITS), "target-outside"),
                (lambda: polyarm.state_to_state([0.0], [1.0], synchronization="x", **LIMITS), "bad-value"),
                (lambda: polyarm.through_waypoints([[0.0], [np.inf]], **LIMITS), "bad-number"),
                (lambda: polyarm.through_waypoints([[0.0], [1]], radius=-1, **LIMITS), "bad-radius"),
                (lambda: polyarm.through_waypoints([[0.0], [1]], velocity=0, acceleration=1, jerk=1), "bad-limit"),
                (lambda: polyarm.through_waypoints([[0.0], [1]], velocity=np.nan, acceleration=1, jerk=1), "bad-number")]:
            with self.assertRaises(polyarm.Error) as caught:
                call()
            self.assertEqual(caught.exception.code, code)
        with self.assertRaises(ValueError):
            polyarm.state_to_state([0.0], [1.0], **LIMITS)(np.nan)

    def test_a_refusal_names_the_joint_or_the_argument(self):
        for call, error, text in [
                (lambda: polyarm.state_to_state([0.0, 0], [1, 1], velocity=[1, 0], acceleration=1, jerk=1), polyarm.Error,
                 "the velocity limit of joint 1 is 0"),
                (lambda: polyarm.state_to_state([0.0, 0], [1, 1], velocity=1, acceleration=1, jerk=[-1, 1]), polyarm.Error,
                 "the jerk limit of joint 0 is -1"),
                (lambda: polyarm.state_to_state([0.0, 0], [1, 1], velocity=[1, 2, 3], acceleration=1, jerk=1), ValueError,
                 r"velocity limits: one number or one for each of 2 joints, not the shape \(3,\)"),
                (lambda: polyarm.state_to_state(([0.0, 0], [1.0]), [1, 1], **LIMITS), ValueError, "velocities: one number or one"),
                (lambda: polyarm.through_waypoints([], **LIMITS), polyarm.Error, "needs two or more"),
                (lambda: polyarm.through_waypoints([[1.0, 2]], **LIMITS), polyarm.Error, "needs two or more")]:
            with self.assertRaisesRegex(error, text):
                call()


if __name__ == "__main__":
    unittest.main()
