"""Episodes: what is written is read back, survives interruptions, and moves a robot again."""
import contextlib
import io
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
import unittest.mock
import zlib

import numpy as np
from polyarm import episodes as episodes_module
from polyarm.episodes import DataSet, png
from polyarm.parquet import Column, encode_table, read_table, write_table
from support import SOURCE

FEATURES = {"observation.state": ["a", "b"], "action": ["a", "b"]}


class InAFolder(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp()) / "set"
        self.addCleanup(shutil.rmtree, self.folder.parent)

    def filled(self, count=3, **options):
        out = DataSet.create(self.folder, FEATURES, fps=20, **options)
        for episode in range(count):
            self.add(out, episode)
        return out

    @staticmethod
    def add(out, episode):
        out.begin(f"task {episode % 2}")
        for frame in range(10 + episode):
            out.add(observation__state=[frame, episode], action=[frame + 0.5, -episode])
        return out.save()


class Parquet(InAFolder):
    def test_every_kind_of_column_comes_back(self):
        random = np.random.default_rng(3)
        for rows in (1, 2, 9, 1000):
            columns = {
                "time": Column("float32", random.normal(size=rows)), "number": Column("int64", np.arange(rows) - 5),
                "wide": Column("float64", random.normal(size=(rows, 7)), lists=True),
                "ragged": Column("float32", [random.normal(size=k % 4) for k in range(rows)], lists=True),
                "text": Column("string", [f"{k} µm" for k in range(rows)]),
                "texts": Column("string", [["x", "yy"][:k % 3] for k in range(rows)], lists=True),
                "picture": Column("image", [bytes([k % 256]) * k for k in range(rows)])}
            self.folder.mkdir(exist_ok=True)
            path = self.folder / "a.parquet"
            write_table(path, columns, {"key": "value"})
            table, metadata = read_table(path)
            self.assertEqual(metadata, {"key": "value"})
            np.testing.assert_array_equal(table["time"], columns["time"].values.astype("f4"))
            np.testing.assert_array_equal(table["number"], columns["number"].values)
            np.testing.assert_array_equal(np.stack(table["wide"]), columns["wide"].values)
            for got, given in zip(table["ragged"], columns["ragged"].values):
                np.testing.assert_array_equal(got, given.astype("f4"))
            self.assertEqual(table["text"], columns["text"].values)
            self.assertEqual(table["texts"], columns["texts"].values)
            self.assertEqual(table["picture"], columns["picture"].values)

    def test_a_damaged_file_is_an_error(self):
        content = encode_table({"a": Column("int64", np.arange(100)), "b": Column("float32", np.ones((100, 3)), lists=True),
                                "c": Column("string", ["text"] * 100)}, {"key": "value"})
        self.folder.mkdir()
        path = self.folder / "a.parquet"
        random = np.random.default_rng(5)
        for round_ in range(3000):
            damaged = bytearray(content)
            for _ in range(random.integers(1, 4)):
                damaged[random.integers(len(damaged))] = random.integers(256)
            if round_ % 3 == 0:
                damaged = damaged[:random.integers(len(damaged))]
            path.write_bytes(damaged)
            with contextlib.suppress(ValueError):
                read_table(path)

    def test_bounds(self):
        with self.assertRaises(ValueError):
            Column("int8", [])
        with self.assertRaises(ValueError):
            encode_table({"a": Column("int64", [1]), "b": Column("int64", [1, 2])})


READERS = SOURCE / "pendant/node_modules"


@unittest.skipUnless(shutil.which("node") and (READERS / "hyparquet").exists(), "needs Node.js and the pendant's packages")
class AnotherLibrary(InAFolder):
    """hyparquet reads what is written."""

    def read(self, *files):
        done = subprocess.run(["node", SOURCE / "tests/python/read_parquet.mjs", READERS, *files], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return [json.loads(line) for line in done.stdout.splitlines()]

    def test_reads_every_kind_of_column(self):
        random = np.random.default_rng(3)
        columns = {"time": Column("float32", random.normal(size=1000)), "number": Column("int64", np.arange(1000) - 5),
                   "wide": Column("float64", random.normal(size=(1000, 7)), lists=True),
                   "ragged": Column("float32", [random.normal(size=k % 4) for k in range(1000)], lists=True),
                   "texts": Column("string", [["x", "yy µ"][:k % 3] for k in range(1000)], lists=True)}
        self.folder.mkdir()
        write_table(self.folder / "a.parquet", columns, {"key": "value"})
        table, = self.read(self.folder / "a.parquet")
        self.assertEqual(table["metadata"], {"key": "value"})
        for name, column in columns.items():
            given = [np.asarray(value).tolist() if column.kind != "float32" else np.asarray(value, np.float32).tolist()
                     for value in column.values]
            self.assertEqual([row[name] for row in table["rows"]], given, name)

    def test_follows_a_data_set_as_lerobot_does(self):
        """By the paths of info.json, and by the descriptions of the episodes."""
        out = DataSet.create(self.folder, FEATURES | {"one": ["x"], "observation.images.front": (4, 6)}, fps=20, video=False)
        for episode in range(3):
            out.begin(f"task {episode % 2}")
            for frame in range(4 + episode):
                out.add(observation__state=[frame, episode], action=[frame + 0.5, -episode], one=[frame],
                        observation__images__front=np.full((4, 6, 3), frame, np.uint8))
            out.save()
        info = json.loads((self.folder / "meta/info.json").read_text())
        tasks, *described = self.read(self.folder / "meta/tasks.parquet", *sorted((self.folder / "meta/episodes").glob("*/*.parquet")))
        self.assertEqual(json.loads(tasks["metadata"]["pandas"])["index_columns"], ["task"])
        numbers = {row["task"]: row["task_index"] for row in tasks["rows"]}
        rows = [row for table in described for row in table["rows"]]
        paths = [self.folder / info["data_path"].format(chunk_index=row["data/chunk_index"], file_index=row["data/file_index"])
                 for row in rows]
        start = 0
        for episode, (row, data) in enumerate(zip(rows, self.read(*paths), strict=True)):
            frames = data["rows"]
            self.assertEqual((row["episode_index"], row["length"], row["dataset_from_index"], row["dataset_to_index"]),
                             (episode, 4 + episode, start, start + len(frames)))
            self.assertEqual(set(frames[0]), set(info["features"]))
            self.assertEqual([frame["index"] for frame in frames], list(range(start, start + len(frames))))
            self.assertEqual({frame["task_index"] for frame in frames}, {numbers[row["tasks"][0]]})
            self.assertEqual([frame["action"] for frame in frames], [[k + 0.5, -episode] for k in range(len(frames))])
            self.assertEqual([frame["one"] for frame in frames], list(range(len(frames))))
            picture = bytes.fromhex(frames[1]["observation.images.front"]["bytes"]["hex"])
            self.assertEqual(picture, png(np.full((4, 6, 3), 1, np.uint8)))
            self.assertEqual(row["stats/action/max"], [len(frames) - 0.5, -episode])
            start += len(frames)
        self.assertEqual((len(rows), start), (info["total_episodes"], info["total_frames"]))


class DataSets(InAFolder):
    def test_what_is_recorded_is_read_back(self):
        self.filled()
        out = DataSet.open(self.folder)
        self.assertEqual(len(out), 3)
        self.assertEqual(out.check(), [])
        self.assertEqual(out.tasks(), ["task 0", "task 1"])
        table = out.read(2)
        np.testing.assert_array_equal(table["action"][:, 0], np.arange(12) + 0.5)
        np.testing.assert_array_equal(table["index"], 21 + np.arange(12))
        np.testing.assert_allclose(table["timestamp"], np.arange(12) / 20, atol=1e-6)
        self.assertEqual([row["tasks"] for row in out.episodes()], [["task 0"], ["task 1"], ["task 0"]])

    def test_info_and_statistics_are_lerobots(self):
        self.filled()
        info = json.loads((self.folder / "meta/info.json").read_text())
        self.assertEqual((info["codebase_version"], info["total_frames"], info["splits"]), ("v3.0", 33, {"train": "0:3"}))
        self.assertEqual(info["features"]["action"], {"dtype": "float32", "shape": [2], "names": ["a", "b"]})
        stats = json.loads((self.folder / "meta/stats.json").read_text())
        every = np.concatenate([DataSet.open(self.folder).read(k)["action"] for k in range(3)])
        for name, value in (("mean", every.mean(0)), ("std", every.std(0)), ("min", every.min(0)), ("max", every.max(0))):
            np.testing.assert_allclose(stats["action"][name], value, atol=1e-6)
        self.assertEqual(stats["action"]["count"], [33])

    def test_bad_frames_are_refused_and_change_nothing(self):
        out = self.filled(1)
        out.begin("task")
        out.add(observation__state=[1, 2], action=[1, 2])
        for bad in ({"action": [1, 2]}, {"observation.state": [1, 2], "action": [1, np.nan]},
                    {"observation.state": [1, 2, 3], "action": [1, 2]}, {"observation.state": [1, 2], "action": [1, np.inf]}):
            with self.assertRaises(ValueError):
                out.add_frame(bad)
        self.assertEqual(out.frames, 1)
        out.discard()
        with self.assertRaises(RuntimeError):
            out.save()
        with self.assertRaises(ValueError):
            out.begin(" ")
        with self.assertRaises(FileExistsError):
            DataSet.create(self.folder, FEATURES, fps=20)
        for fps in (0, 2.5, 5000):
            with self.assertRaises(ValueError):
                DataSet.create(self.folder.parent / "other", FEATURES, fps=fps)

    def test_an_interruption_anywhere_loses_the_running_episode_alone(self):
        """The process ends at each write in turn."""
        write, name = episodes_module.write_file, "polyarm.parquet.write_file"
        for ends_at in range(1, 8):
            shutil.rmtree(self.folder, ignore_errors=True)
            out = self.filled(2)
            calls = 0

            class Ends(BaseException):
                pass

            def write_until(path, content):
                nonlocal calls
                calls += 1
                if calls == ends_at:
                    pathlib.Path(f"{path}.writing").write_bytes(b"half")
                    raise Ends
                write(path, content)

            ended = False
            try:
                with unittest.mock.patch(name, write_until), \
                        unittest.mock.patch.object(episodes_module, "write_file", write_until):
                    self.add(out, 2)
            except Ends:
                ended = True
            again = DataSet.open(self.folder)
            self.assertIn(len(again), (2, 3) if ended else (3,))
            self.assertEqual(again.check(), [], f"write {ends_at}")
            self.assertEqual(self.add(again, len(again)), len(again) - 1)
            self.assertEqual(DataSet.open(self.folder).check(), [])

    def test_two_writers_lose_nothing(self):
        first = self.filled(1)
        second = DataSet.open(self.folder)
        self.assertEqual([self.add(first, 1), self.add(second, 2), self.add(second, 3), self.add(first, 4)], [1, 2, 3, 4])
        self.assertEqual(DataSet.open(self.folder).check(), [])
        self.assertEqual([row["length"] for row in first.episodes()], [10, 11, 12, 13, 14])
        second.drop(0)
        self.assertEqual(self.add(first, 0), 4)
        with self.assertRaises(IndexError):
            second.drop(5)
        self.assertEqual([row["length"] for row in second.episodes()], [11, 12, 13, 14, 10])
        self.assertEqual(DataSet.open(self.folder).check(), [])

    def test_processes_record_into_one_set_side_by_side(self):
        self.filled(0)
        children = []
        for k in range(3):
            child = os.fork()
            if child == 0:
                try:
                    for _ in range(4):
                        self.add(DataSet.open(self.folder), k)
                    os._exit(0)
                finally:
                    os._exit(1)
            children.append(child)
        self.assertEqual([os.waitpid(child, 0)[1] for child in children], [0, 0, 0])
        found = DataSet.open(self.folder)
        self.assertEqual((len(found), found.check()), (12, []))
        self.assertEqual(sorted(row["length"] for row in found.episodes()), [10] * 4 + [11] * 4 + [12] * 4)

    def test_another_set_in_its_place_is_not_written_to(self):
        old = self.filled(1)
        shutil.rmtree(self.folder)
        DataSet.create(self.folder, {"observation.state": ["z"]}, fps=20)
        with self.assertRaisesRegex(ValueError, "is another data set now"):
            self.add(old, 0)
        self.assertEqual(len(DataSet.open(self.folder)), 0)

    def test_a_dropped_episode_leaves_no_gap(self):
        for gone in range(3):
            shutil.rmtree(self.folder, ignore_errors=True)
            out = self.filled()
            kept = [out.read(k)["action"] for k in range(3) if k != gone]
            out.drop(gone)
            again = DataSet.open(self.folder)
            self.assertEqual(again.check(), [])
            for number, action in enumerate(kept):
                np.testing.assert_array_equal(again.read(number)["action"], action)
            stats = json.loads((self.folder / "meta/stats.json").read_text())
            np.testing.assert_allclose(stats["action"]["mean"], np.concatenate(kept).mean(0), atol=1e-6)
            with self.assertRaises(IndexError):
                again.drop(2)
        self.assertEqual([path.name for path in self.folder.parent.iterdir()], ["set"])

    def test_an_interrupted_drop_leaves_the_old_or_the_new_set(self):
        self.filled()
        own = self.folder.with_name("set.old")  # a folder of the user
        shutil.copytree(self.folder, own)
        old = self.folder.with_name(".set.drop-old")
        os.rename(self.folder, old)
        self.assertEqual(len(DataSet.open(self.folder)), 3)
        self.assertFalse(old.exists())
        self.assertEqual(DataSet.open(self.folder).check(), [])
        self.assertTrue(own.exists())

    def test_check_names_what_is_wrong(self):
        self.filled()
        path = self.folder / "data/chunk-000/file-001.parquet"
        content = bytearray(path.read_bytes())
        content[len(content) // 3] ^= 0x55
        path.write_bytes(content)
        (self.folder / "meta/info.json").write_text(
            (self.folder / "meta/info.json").read_text().replace('"total_frames": 33', '"total_frames": 34'))
        findings = DataSet.open(self.folder).check()
        self.assertTrue(any("episode 1" in finding for finding in findings), findings)

    def test_pictures_are_kept(self):
        out = DataSet.create(self.folder, FEATURES | {"observation.images.front": (4, 6)}, fps=10, video=False)
        image = np.arange(72, dtype=np.uint8).reshape(4, 6, 3)
        out.begin("look")
        for _ in range(3):
            out.add(observation__state=[0, 0], action=[0, 0], observation__images__front=image)
        with self.assertRaises(ValueError):
            out.add(observation__state=[0, 0], action=[0, 0], observation__images__front=image.astype(float))
        out.save()
        self.assertEqual(out.check(), [])
        picture = out.read(0)["observation.images.front"][1]
        self.assertEqual(picture, png(image))
        lines = zlib.decompress(picture[picture.index(b"IDAT") + 4:-16])
        np.testing.assert_array_equal(np.frombuffer(lines, np.uint8).reshape(4, 19)[:, 1:].reshape(4, 6, 3), image)
        stats = json.loads((self.folder / "meta/stats.json").read_text())["observation.images.front"]
        self.assertEqual(np.shape(stats["mean"]), (3, 1, 1))
        out.begin("look again")
        out.add(observation__state=[0, 0], action=[0, 0], observation__images__front=image)
        out.save()
        out.drop(0)
        self.assertEqual(DataSet.open(self.folder).check(), [])

    @unittest.skipUnless(shutil.which("ffmpeg"), "needs ffmpeg")
    def test_videos_are_made(self):
        out = DataSet.create(self.folder, FEATURES | {"observation.images.front": (48, 64)}, fps=10, video=True)
        for _ in range(2):
            out.begin("look")
            for frame in range(12):
                out.add(observation__state=[0, 0], action=[0, 0],
                        observation__images__front=np.full((48, 64, 3), 20 * frame, np.uint8))
            out.save()
        self.assertEqual(out.check(), [])
        out.drop(0)
        self.assertEqual(DataSet.open(self.folder).check(), [])
        video = self.folder / "videos/observation.images.front/chunk-000/file-000.mp4"
        probed = subprocess.run(["ffprobe", "-v", "error", "-of", "json", "-show_streams", "-count_frames", str(video)],
                                capture_output=True, text=True, check=True)
        stream, = json.loads(probed.stdout)["streams"]
        info = out.features["observation.images.front"]["info"]
        self.assertEqual([stream[key] for key in ("height", "width", "codec_name", "pix_fmt", "r_frame_rate", "nb_read_frames")],
                         [info["video.height"], info["video.width"], info["video.codec"], info["video.pix_fmt"],
                          f"{info['video.fps']}/1", "12"])
        with self.assertRaisesRegex(ValueError, "49 x 64 pixels"):
            DataSet.create(self.folder.parent / "odd", {"observation.images.front": (49, 64)}, fps=10, video=True)

    def test_the_command_lists_checks_and_drops(self):
        self.filled()

        def said(*words):
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                code = episodes_module.main([*words])
            return code, out.getvalue()

        folder = str(self.folder)
        self.assertIn("3 episodes, 33 frames at 20 Hz", said("list", folder)[1])
        self.assertEqual(said("check", folder), (0, "no faults\n"))
        self.assertEqual(said("drop", folder, "1")[0], 0)
        self.assertEqual(said("drop", folder, "7")[0], 1)
        self.assertEqual(said("list", str(self.folder.parent / "none"))[0], 1)
        command = subprocess.run([sys.executable, "-m", "polyarm.episodes", "check", folder], capture_output=True, check=False)
        self.assertEqual(command.returncode, 0, command.stderr)


if __name__ == "__main__":
    unittest.main()
