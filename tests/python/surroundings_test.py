"""Ways around obstacles: free, repeatable, refused with a reason."""
import pathlib
import shutil
import tempfile
import unittest

import numpy as np
import polyarm

SCENE = """polyarm: scene/1
floor: {height: -0.75}
fixtures:
  shelf: {box: [0.1, 0.2, 0.5], at: [0.45, 0, 0.25]}
"""
DOWN = (np.pi, 0, 0)


class Around(unittest.TestCase):
    def setUp(self):
        folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, folder)
        self.scene = folder / "scene.yaml"
        self.scene.write_text(SCENE)
        self.arm = polyarm.Robot("universal_robots/ur5e")
        self.left = self.arm.ik(polyarm.pose((0.4, 0.4, 0.3), rpy=DOWN))
        self.right = polyarm.pose((0.4, -0.4, 0.3), rpy=DOWN)
        self.near = self.arm.ik(self.right, seed=self.left)  # on the other side, in the same configuration

    def test_a_way_and_its_motion_touch_nothing_where_the_straight_line_does(self):
        world = polyarm.Surroundings(self.arm, self.scene)
        way = world.plan(self.left, self.near)
        np.testing.assert_allclose(way.waypoints[0], self.left)
        np.testing.assert_allclose(way.waypoints[-1], self.near)
        self.assertEqual(len(way.radii), len(way.waypoints))
        self.assertTrue(world.touches(np.linspace(self.left, self.near, 200)).any())
        motion = way.timed(velocity=2, acceleration=8, jerk=80)
        self.assertFalse(world.touches(motion(np.linspace(0, motion.duration, 500))).any())

    def test_a_pose_is_reached_by_any_branch(self):
        way = polyarm.Surroundings(self.arm, self.scene).plan(self.left, self.right)
        np.testing.assert_allclose(self.arm.fk(way.waypoints[-1]), self.right, atol=1e-8)

    def test_the_same_seed_gives_the_same_way(self):
        first, second = (polyarm.Surroundings(self.arm, self.scene).plan(self.left, self.near, seed=7) for _ in range(2))
        np.testing.assert_array_equal(first.waypoints, second.waypoints)

    def test_the_distance_agrees_with_the_verdict(self):
        world = polyarm.Surroundings(self.arm, self.scene)
        states = np.random.default_rng(2).uniform(-2, 2, (60, 6))
        for q, touching in zip(states, world.touches(states)):
            if abs(world.nearest(q)[2]) > 1e-3:
                self.assertEqual(world.nearest(q)[2] < 0, touching)
        self.assertIs(world.touches(self.left), False)

    def test_contacts_and_missing_ways_have_codes(self):
        world = polyarm.Surroundings(self.arm, self.scene)
        inside = self.arm.ik(polyarm.pose((0.45, 0, 0.3), rpy=DOWN))
        far = polyarm.pose((3, 0, 0))
        for code, start, goal, samples in [("start-in-contact", inside, self.left, 100), ("goal-in-contact", self.left, inside, 100),
                                           ("unreachable", self.left, far, 100), ("no-way", self.left, self.near, 0)]:
            with self.assertRaises(polyarm.Error) as caught:
                world.plan(start, goal, most_samples=samples)
            self.assertEqual(caught.exception.code, code)
            self.assertTrue(str(caught.exception))
        with self.assertRaises(polyarm.Error):
            polyarm.Surroundings(self.arm, clearance=np.nan)
        with self.assertRaises(polyarm.Error):
            polyarm.Surroundings(self.arm, "nowhere.yaml")


if __name__ == "__main__":
    unittest.main()
