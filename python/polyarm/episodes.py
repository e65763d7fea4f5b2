"""Episodes of robots as a LeRobot data set (version 3.0): recording, listing, checking, dropping.

    from polyarm.episodes import DataSet
    from polyarm.record import features_of, joints_of, record

    with polyarm.Cell("my_cell") as cell:
        episodes = DataSet.create("my_episodes", features_of(joints_of(cell)), fps=30)
        record(cell, episodes, task="Put the cube into the box", seconds=10)

Each episode is a file of its own, written whole when it ends: an interruption loses at most the running episode. On the
command line: python3 -m polyarm.episodes --help
"""
import contextlib
import fcntl
import json
import os
import pathlib
import re
import shutil
import struct
import subprocess
import tempfile
import zlib

import numpy as np

from ._statistics import image_statistics, statistics, together
from .parquet import Column, pandas_index, read_table, write_file, write_table

__all__ = ["DataSet", "png"]

VERSION = "v3.0"
_CHUNK = 1000  # episodes in a folder
_MOST_FRAMES = 1_000_000  # of one episode
_DATA = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
_META = "meta/episodes/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
_VIDEO = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
_OWN = {"timestamp": "float32", "frame_index": "int64", "episode_index": "int64", "index": "int64", "task_index": "int64"}
_TIMESTAMP_TOLERANCE = 1e-4  # s, as LeRobot


def png(image):
    """The picture as a PNG. `image`: height x width x 3, uint8."""
    image = np.ascontiguousarray(image)
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3 or 0 in image.shape:
        raise ValueError("a picture is an array of height x width x 3 of uint8")
    height, width, _ = image.shape
    lines = np.concatenate([np.zeros((height, 1), np.uint8), image.reshape(height, -1)], axis=1).tobytes()

    def part(name, content):
        return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))

    return b"\x89PNG\r\n\x1a\n" + part(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) + \
        part(b"IDAT", zlib.compress(lines, 4)) + part(b"IEND", b"")


def _described_camera(name, height, width, video_fps):
    """A camera in info.json. `video_fps`: None if its pictures are kept."""
    out = {"dtype": "image" if video_fps is None else "video", "shape": [height, width, 3],
           "names": ["height", "width", "channels"]}
    if video_fps is None:
        return out
    if height % 2 or width % 2:
        raise ValueError(f"'{name}' has {height} x {width} pixels, and a video needs even numbers: crop a line, or use video=False")
    return out | {"info": {"video.height": height, "video.width": width, "video.codec": "h264", "video.pix_fmt": "yuv420p",
                           "video.is_depth_map": False, "video.fps": video_fps, "video.channels": 3, "has_audio": False}}


def _place(episode):
    return {"chunk_index": episode // _CHUNK, "file_index": episode % _CHUNK}


@contextlib.contextmanager
def _only_writer(folder):
    """Other processes that write data sets in the same place wait. The lock is that of the folder above, since drop()
    exchanges the folder itself. A file system without such locks has none."""
    above = os.open(folder.absolute().parent, os.O_RDONLY | os.O_DIRECTORY)
    try:
        with contextlib.suppress(OSError):
            fcntl.flock(above, fcntl.LOCK_EX)
        yield
    finally:
        os.close(above)


class DataSet:
    """A LeRobot data set in a folder. create() makes a new one, open() continues one. Several processes may record into
    one: their episodes get the next free numbers."""

    def __init__(self, folder, info):
        self.folder, self.info = pathlib.Path(folder), info
        self._frames, self._task = None, ""

    @classmethod
    def create(cls, folder, features, fps, robot_type="", video=None):
        """`features`: {name: names of its values}, such as {"observation.state": ["joint_1", …], "action": […]}; a
        camera is {"observation.images.NAME": (height, width)}. `video`: cameras become MP4 (needs ffmpeg); by default if
        ffmpeg is installed, else pictures."""
        folder = pathlib.Path(folder)
        if (folder / "meta" / "info.json").exists():
            raise FileExistsError(f"{folder} has a data set already: DataSet.open() continues it")
        if not (0 < fps <= 1000 and fps == int(fps)):
            raise ValueError(f"{fps} frames per second: a whole number from 1 to 1000")
        cameras = [name for name in features if name.startswith("observation.images.")]
        video = bool(cameras) and (shutil.which("ffmpeg") is not None if video is None else video)
        if video and not shutil.which("ffmpeg"):
            raise FileNotFoundError("video needs ffmpeg: install it, or use video=False")
        described = {}
        for name, names in features.items():
            if not re.fullmatch(r"[A-Za-z0-9_.]{1,100}", name) or name in _OWN:
                raise ValueError(f"'{name}' is no name of a feature: letters, digits, '_' and '.'")
            if name in cameras:
                described[name] = _described_camera(name, *map(int, names), int(fps) if video else None)
            else:
                described[name] = {"dtype": "float32", "shape": [len(names)], "names": list(names)}
        described |= {name: {"dtype": kind, "shape": [1], "names": None} for name, kind in _OWN.items()}
        info = {"codebase_version": VERSION, "robot_type": robot_type or None, "total_episodes": 0, "total_frames": 0,
                "total_tasks": 0, "chunks_size": _CHUNK, "data_files_size_in_mb": 100, "video_files_size_in_mb": 200,
                "fps": int(fps), "splits": {}, "data_path": _DATA, "video_path": _VIDEO if video else None,
                "features": described}
        out = cls(folder, info)
        out._write_meta([], [])
        return out

    @classmethod
    def open(cls, folder, recover=True):
        """Continues a data set that create() made. What an interruption left half-written is removed; not with
        recover=False, which changes nothing: another process may be recording."""
        folder = pathlib.Path(folder)
        with _only_writer(folder) if recover and folder.absolute().parent.is_dir() else contextlib.nullcontext():
            if recover:
                _finish_drop(folder)
            out = cls(folder, _read_info(folder))
            if recover:
                out._recover()
        return out

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.discard()

    @property
    def features(self):
        """The features that add() takes, with their description."""
        return {name: feature for name, feature in self.info["features"].items() if name not in _OWN}

    @property
    def fps(self):
        return self.info["fps"]

    def __len__(self):
        return self.info["total_episodes"]

    # Recording.

    def begin(self, task):
        """A new episode; `task` is what the robot is to do, in words. An episode that was not saved is discarded."""
        if not isinstance(task, str) or not task.strip() or len(task) > 1000:
            raise ValueError("the task is a text of 1 to 1000 characters")
        self._frames, self._task = {name: [] for name in self.features}, task

    def add(self, **values):
        """The next frame. A dot in a feature's name is written as __: add(observation__state=…, action=…)."""
        self.add_frame({name.replace("__", "."): value for name, value in values.items()})

    def add_frame(self, frame):
        """The next frame as {feature: value}. All values must be finite."""
        if self._frames is None:
            raise RuntimeError("there is no episode: begin() first")
        if set(frame) != set(self.features):
            raise ValueError(f"a frame has {sorted(self.features)}, not {sorted(frame)}")
        checked = {}
        for name, feature in self.features.items():
            kind = np.uint8 if feature["dtype"] in ("image", "video") else np.float32
            value = np.asarray(frame[name])
            if list(value.shape) != feature["shape"] or (kind is np.uint8 and value.dtype != kind):
                raise ValueError(f"'{name}' has the shape {value.shape} and the type {value.dtype}, not "
                                 f"{tuple(feature['shape'])}")
            value = value.astype(kind)
            if kind is np.float32 and not np.isfinite(value).all():
                raise ValueError(f"'{name}' has a value that is no finite number")
            checked[name] = value
        if len(next(iter(self._frames.values()))) >= _MOST_FRAMES:
            raise ValueError("the episode is too long")
        for name, value in checked.items():
            self._frames[name].append(value)

    @property
    def frames(self):
        """The number of frames of the running episode."""
        return len(next(iter(self._frames.values()))) if self._frames else 0

    def discard(self):
        """Forgets the running episode."""
        self._frames = None

    def save(self):
        """Writes the running episode; its number. From then on it is in the data set."""
        if not self.frames:
            raise RuntimeError("the episode has no frames")
        with _only_writer(self.folder):
            self._read_anew()
            return self._save()

    def _save(self):
        frames, count, episode = self._frames, self.frames, len(self)
        tasks = self.tasks()
        if self._task not in tasks:
            tasks.append(self._task)
            self._write_tasks(tasks)
        start, place = self.info["total_frames"], _place(episode)
        stats = {name: image_statistics(values) if feature["dtype"] in ("image", "video") else statistics(values)
                 for name, feature in self.features.items() for values in [frames[name]]}
        own = self._own_columns(episode, start, count, tasks.index(self._task))
        stats |= {name: statistics(column.values) for name, column in own.items()}
        row = {"episode_index": Column("int64", [episode]), "tasks": Column("string", [[self._task]], lists=True),
               "length": Column("int64", [count]), "data/chunk_index": Column("int64", [place["chunk_index"]]),
               "data/file_index": Column("int64", [place["file_index"]]), "dataset_from_index": Column("int64", [start]),
               "dataset_to_index": Column("int64", [start + count])}
        columns = {}
        for name, feature in self.features.items():
            if feature["dtype"] == "video":
                self._write_video(name, place, frames[name])
                row |= {f"videos/{name}/chunk_index": Column("int64", [place["chunk_index"]]),
                        f"videos/{name}/file_index": Column("int64", [place["file_index"]]),
                        f"videos/{name}/from_timestamp": Column("float64", [0.0]),
                        f"videos/{name}/to_timestamp": Column("float64", [count / self.fps])}
            elif feature["dtype"] == "image":
                columns[name] = Column("image", [png(image) for image in frames[name]])
            elif feature["shape"] == [1]:
                columns[name] = Column("float32", np.concatenate(frames[name]))
            else:
                columns[name] = Column("float32", np.stack(frames[name]), lists=True)
        row |= {f"stats/{feature}/{kind}": Column("float64", [np.ravel(value)], lists=True)
                for feature, of in stats.items() for kind, value in of.items()}
        row |= {"meta/episodes/chunk_index": Column("int64", [place["chunk_index"]]),
                "meta/episodes/file_index": Column("int64", [place["file_index"]])}
        write_table(str(self.folder / _DATA.format(**place)), columns | own, _hugging_face(self.info["features"]))
        write_table(str(self.folder / _META.format(**place)), row)  # now it counts
        self._frames = None
        self.info["total_episodes"], self.info["total_frames"] = episode + 1, start + count
        self._write_meta(tasks, [*self._stats_so_far(), stats] if episode else [stats])
        return episode

    # Reading.

    def tasks(self):
        """The texts of the tasks, by their number."""
        path = self.folder / "meta" / "tasks.parquet"
        return read_table(path)[0]["task"] if path.exists() else []

    def episodes(self):
        """A dict for each episode: episode_index, tasks, length, dataset_from_index, …"""
        return [{name: values[0] for name, values in read_table(path)[0].items() if not name.startswith("stats/")}
                for path in self._files(_META)]

    def read(self, episode):
        """{feature: array} of one episode; pictures are PNGs."""
        if not 0 <= episode < len(self):
            raise IndexError(f"there is no episode {episode}; there are {len(self)}")
        table, _ = read_table(self.folder / _DATA.format(**_place(episode)))
        return {name: np.stack(values) if isinstance(values, list) and len(values) and isinstance(values[0], np.ndarray)
                else values for name, values in table.items()}

    def check(self):
        """Everything that is wrong, as a list of texts: damaged files, gaps, values that are no numbers, times."""
        out, start, tasks = [], 0, self.tasks()
        rows = self._files(_META)
        if len(rows) != len(self):
            out.append(f"info.json counts {len(self)} episodes, and {len(rows)} are described")
        for episode in range(len(self)):
            try:
                start += self._check_episode(episode, start, tasks, out)
            except (OSError, ValueError, KeyError) as error:
                out.append(f"episode {episode} cannot be read: {error}")
        if start != self.info["total_frames"] and not out:
            out.append(f"info.json counts {self.info['total_frames']} frames, and there are {start}")
        known = {str(self.folder / _DATA.format(**_place(episode))) for episode in range(len(self))}
        out += [f"{path} belongs to no episode" for path in self._files(_DATA) if str(path) not in known]
        return out

    def drop(self, episode):
        """Removes one episode; those after it get the next lower numbers. An interruption leaves the old or the new set."""
        with _only_writer(self.folder):
            self._read_anew()
            self._drop(episode)

    def _drop(self, episode):
        if not 0 <= episode < len(self):
            raise IndexError(f"there is no episode {episode}; there are {len(self)}")
        new, old_set = _drop_folders(self.folder)
        shutil.rmtree(new, ignore_errors=True)
        kept = DataSet(new, {**self.info, "total_episodes": 0, "total_frames": 0, "splits": {}})
        shutil.copytree(self.folder / "meta", new / "meta", ignore=shutil.ignore_patterns("episodes", "*.writing"))
        all_stats = []
        for old in range(len(self)):
            if old != episode:
                all_stats.append(kept._take_over(self, old))
        kept._write_meta(self.tasks(), all_stats)
        os.sync()  # copies of videos are on the disk before the old set goes
        os.rename(self.folder, old_set)
        os.rename(new, self.folder)
        shutil.rmtree(old_set)
        self.info = kept.info

    # Inside.

    def _read_anew(self):
        """Takes over what another process has recorded or dropped."""
        info = _read_info(self.folder)
        if info["features"] != self.info["features"] or info["fps"] != self.info["fps"]:
            raise ValueError(f"{self.folder} is another data set now: open it again")
        self.info = info
        self._recover()

    def _own_columns(self, episode, start, count, task):
        index = np.arange(count)
        return {"timestamp": Column("float32", index / self.fps), "frame_index": Column("int64", index),
                "episode_index": Column("int64", np.full(count, episode)), "index": Column("int64", start + index),
                "task_index": Column("int64", np.full(count, task))}

    def _files(self, pattern):
        head = pattern.split("/chunk-")[0]
        return sorted((self.folder / head).glob("chunk-*/file-*.parquet"))

    def _stats_so_far(self):
        """Those of all episodes as one."""
        stored = json.loads((self.folder / "meta" / "stats.json").read_text())
        return [{feature: {kind: np.asarray(value) for kind, value in of.items()} for feature, of in stored.items()}]

    def _stats_of(self, episode):
        table, _ = read_table(self.folder / _META.format(**_place(episode)))
        out = {}
        for name, values in table.items():
            if name.startswith("stats/"):
                _, feature, kind = name.split("/")
                picture = feature.startswith("observation.images.") and kind != "count"
                out.setdefault(feature, {})[kind] = values[0].reshape(-1, 1, 1) if picture else values[0]
        return out

    def _write_tasks(self, tasks):
        write_table(str(self.folder / "meta" / "tasks.parquet"),
                    {"task_index": Column("int64", np.arange(len(tasks))), "task": Column("string", tasks)},
                    pandas_index("task", {"task_index": "int64", "task": "unicode"}))

    def _write_meta(self, tasks, all_stats):
        """What describes all episodes together; info.json comes last."""
        meta = self.folder / "meta"
        meta.mkdir(parents=True, exist_ok=True)
        if all_stats:
            stats = {feature: together([stats[feature] for stats in all_stats]) for feature in all_stats[0]}
            write_file(str(meta / "stats.json"), json.dumps(
                {feature: {kind: value.tolist() for kind, value in of.items()} for feature, of in stats.items()}, indent=1))
        if tasks:
            self._write_tasks(tasks)
        self.info["total_tasks"] = len(tasks)
        self.info["splits"] = {"train": f"0:{len(self)}"} if len(self) else {}
        write_file(str(meta / "info.json"), json.dumps(self.info, indent=1, ensure_ascii=False))

    def _write_video(self, name, place, images):
        path = self.folder / _VIDEO.format(video_key=name, **place)
        path.parent.mkdir(parents=True, exist_ok=True)
        height, width, _ = images[0].shape
        with tempfile.TemporaryDirectory(dir=path.parent) as folder:
            made = pathlib.Path(folder) / "video.mp4"
            done = subprocess.run(
                ["ffmpeg", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r",
                 str(self.fps), "-i", "-", "-an", "-c:v", "libx264", "-pix_fmt", "yuv420p", "-g", "2", "-crf", "18", str(made)],
                input=b"".join(image.tobytes() for image in images), capture_output=True, check=False)
            if done.returncode:
                raise OSError(f"ffmpeg has made no video of '{name}': {done.stderr.decode(errors='replace')[-500:]}")
            with open(made, "rb") as file:
                os.fsync(file.fileno())
            os.replace(made, path)

    def _recover(self):
        """Removes what belongs to no episode, and counts anew: after an interruption."""
        rows = self._files(_META)
        described = len(rows)
        for episode, path in enumerate(rows):  # only an unbroken series counts
            if path != self.folder / _META.format(**_place(episode)):
                described = episode
                break
        for path in self._files(_DATA)[described:]:
            path.unlink()
        for path in self.folder.rglob("*.writing"):
            path.unlink()
        if described == len(self):
            return
        self.info["total_episodes"] = described
        self.info["total_frames"] = sum(row["length"] for row in self.episodes()[:described])
        self.info = json.loads(json.dumps(self.info, default=int))
        self._write_meta(self.tasks(), [self._stats_of(episode) for episode in range(described)])

    def _check_episode(self, episode, start, tasks, out):
        """Appends findings; the number of frames."""
        row = {name: values[0] for name, values in read_table(self.folder / _META.format(**_place(episode)))[0].items()}
        table = self.read(episode)
        count = len(table["index"])

        def expect(true, text):
            if not true:
                out.append(f"episode {episode}: {text}")

        expect(row["length"] == count and row["dataset_from_index"] == start and row["dataset_to_index"] == start + count,
               f"its description has another place or length than its {count} frames from {start}")
        expect(set(table) == {name for name, feature in self.info["features"].items() if feature["dtype"] != "video"},
               "its features are not those of the data set")
        for name, feature in self.features.items():
            if feature["dtype"] == "video":
                path = self.folder / _VIDEO.format(video_key=name, **_place(episode))
                expect(path.exists() and path.stat().st_size > 0, f"the video of '{name}' is missing")
            elif feature["dtype"] == "image":
                expect(all(picture.startswith(b"\x89PNG") for picture in table[name]), f"'{name}' has no PNG")
            else:
                values = np.asarray(table[name])
                expect(values.reshape(count, -1).shape == (count, feature["shape"][0]), f"'{name}' has another shape")
                expect(np.isfinite(values).all(), f"'{name}' has values that are no numbers")
        index = np.arange(count)
        expect(np.array_equal(table["frame_index"], index) and np.array_equal(table["index"], start + index)
               and (table["episode_index"] == episode).all(), "its numbers of frames are not in order")
        expect(np.abs(table["timestamp"] - index / self.fps).max(initial=0) < max(_TIMESTAMP_TOLERANCE, 1e-6 * count),
               "its times do not fit the frames per second")
        expect(((table["task_index"] >= 0) & (table["task_index"] < len(tasks))).all(), "its task does not exist")
        return count

    def _take_over(self, other, old):
        """An episode of another data set as the next one of this; its statistics."""
        episode, start = len(self), self.info["total_frames"]
        here, there = _place(episode), _place(old)
        table, metadata = read_table(other.folder / _DATA.format(**there))
        count = len(table["index"])
        table["episode_index"], table["index"] = np.full(count, episode), start + np.arange(count)
        features = self.info["features"]
        columns = {name: Column("image" if features[name]["dtype"] == "image" else features[name]["dtype"], values,
                                lists=features[name]["shape"] != [1] and features[name]["dtype"] == "float32")
                   for name, values in table.items()}
        stats = other._stats_of(old)
        for name in ("episode_index", "index"):
            stats[name] = statistics(table[name])
        row, _ = read_table(other.folder / _META.format(**there))
        row["episode_index"], row["dataset_from_index"], row["dataset_to_index"] = [episode], [start], [start + count]
        for name in list(row):
            if name.endswith("/chunk_index"):
                row[name] = [here["chunk_index"]]
            elif name.endswith("/file_index"):
                row[name] = [here["file_index"]]
            elif name.startswith("stats/"):
                _, feature, kind = name.split("/")
                row[name] = [np.ravel(stats[feature][kind])]
        kinds = {name: "string" if name == "tasks" else "float64" if name.startswith("stats/") or name.endswith("timestamp")
                 else "int64" for name in row}
        for name, feature in self.features.items():
            if feature["dtype"] == "video":
                target = self.folder / _VIDEO.format(video_key=name, **here)
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(other.folder / _VIDEO.format(video_key=name, **there), target)
        write_table(str(self.folder / _DATA.format(**here)), columns, metadata)
        write_table(str(self.folder / _META.format(**here)),
                    {name: Column(kinds[name], values, lists=name == "tasks" or name.startswith("stats/"))
                     for name, values in row.items()})
        self.info["total_episodes"], self.info["total_frames"] = episode + 1, start + count
        return stats


def _hugging_face(features):
    """The metadata from which the library `datasets` takes the types of columns."""
    described = {}
    for name, feature in features.items():
        if feature["dtype"] == "video":
            continue
        if feature["dtype"] == "image":
            described[name] = {"_type": "Image"}
        elif feature["shape"] == [1]:
            described[name] = {"dtype": feature["dtype"], "_type": "Value"}
        else:
            described[name] = {"feature": {"dtype": feature["dtype"], "_type": "Value"}, "length": feature["shape"][0],
                               "_type": "Sequence"}
    return {"huggingface": json.dumps({"info": {"features": described}})}


def _read_info(folder):
    info = json.loads((folder / "meta" / "info.json").read_text())
    if info.get("codebase_version") != VERSION or info.get("data_path") != _DATA:
        raise ValueError(f"{folder} is not of this writer, or of another version than {VERSION}")
    return info


def _drop_folders(folder):
    """The new and the old data set while drop() exchanges them. Names that nobody gives to a folder of their own."""
    return folder.with_name(f".{folder.name}.drop-new"), folder.with_name(f".{folder.name}.drop-old")


def _finish_drop(folder):
    """What drop() has not finished: the whole new or the whole old data set is kept."""
    new, old = _drop_folders(folder)
    if not folder.exists() and old.exists():
        os.rename(new if (new / "meta" / "info.json").exists() else old, folder)
    shutil.rmtree(new, ignore_errors=True)
    shutil.rmtree(old, ignore_errors=True)


def _print_list(arguments):
    episodes = DataSet.open(arguments.folder, recover=False)
    print(f"{len(episodes)} episodes, {episodes.info['total_frames']} frames at {episodes.fps} Hz")
    for row in episodes.episodes():
        print(f"{row['episode_index']:5d}  {row['length'] / episodes.fps:7.1f} s  {', '.join(row['tasks'])}")
    return 0


def _print_check(arguments):
    findings = DataSet.open(arguments.folder, recover=False).check()
    for finding in findings:
        print(finding)
    print("no faults" if not findings else f"{len(findings)} faults")
    return 1 if findings else 0


def _drop(arguments):
    episodes = DataSet.open(arguments.folder)
    episodes.drop(arguments.episode)
    print(f"episode {arguments.episode} is gone; {len(episodes)} are left")
    return 0


async def _record(arguments):
    from .client import connect
    from .record import features_of, record_running, running_joints

    async with await connect(arguments.cell, name="recording of episodes") as client:
        folder = pathlib.Path(arguments.folder)
        features = features_of(await running_joints(client, arguments.robot))
        if (folder / "meta" / "info.json").exists():
            episodes = DataSet.open(folder)
            there = {name: feature["names"] for name, feature in episodes.features.items()}
            if there != features:
                raise ValueError(f"{folder} has other features than '{arguments.robot}' of this cell: {there}, not {features}")
            if arguments.fps not in (None, episodes.fps):
                raise ValueError(f"{folder} has {episodes.fps} frames per second, not {arguments.fps}")
        else:
            fps = 30 if arguments.fps is None else arguments.fps
            episodes = DataSet.create(folder, features, fps, robot_type=arguments.robot)
        for _ in range(arguments.episodes):
            print(f"episode {len(episodes)} begins", flush=True)
            number = await record_running(client, episodes, arguments.task, arguments.robot, arguments.seconds)
            print(f"episode {number} is saved", flush=True)
    return 0


def main(words=None):
    import argparse
    import asyncio

    from .errors import Error

    parser = argparse.ArgumentParser(prog="python3 -m polyarm.episodes", description="Episodes as a LeRobot data set.")
    verbs = parser.add_subparsers(dest="verb", required=True)
    recording = verbs.add_parser("record", help="record episodes of a running cell")
    recording.add_argument("folder")
    recording.add_argument("--cell", required=True, help="the link of its page, or its name")
    recording.add_argument("--task", required=True, help="what the robot is to do, in words")
    recording.add_argument("--robot", default="arm")
    recording.add_argument("--fps", type=int, help="frames per second of a new data set (30)")
    recording.add_argument("--seconds", type=float, default=10)
    recording.add_argument("--episodes", type=int, default=1)
    for name, what in (("list", "list the episodes"), ("check", "find faults of a data set"), ("drop", "remove an episode")):
        verb = verbs.add_parser(name, help=what)
        verb.add_argument("folder")
        if name == "drop":
            verb.add_argument("episode", type=int)
    arguments = parser.parse_args(words)
    try:
        if arguments.verb == "record":
            return asyncio.run(_record(arguments))
        return {"list": _print_list, "check": _print_check, "drop": _drop}[arguments.verb](arguments)
    except KeyboardInterrupt:
        print("the running episode is discarded; those before it are saved")
        return 130
    except (Error, OSError, ValueError, IndexError) as error:
        print(f"error: {error}")
        return 1


if __name__ == "__main__":
    raise SystemExit(main())
