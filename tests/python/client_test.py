"""The asyncio client with a running cell: on the local socket and on the pendant's port."""
import asyncio
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

from polyarm.client import Closed, connect, running_cells
from polyarm.errors import Error
from support import COMMAND, EXAMPLES, SOURCE, wait_for_cell


class Alone(unittest.TestCase):
    def test_it_needs_neither_the_compiled_module_nor_numpy(self):
        script = ("import sys\n"
                  "sys.modules['numpy'] = sys.modules['polyarm._polyarm'] = None\n"
                  "import polyarm.client, polyarm.errors\n"
                  "try:\n"
                  "    polyarm.Robot\n"
                  "except ImportError:\n"
                  "    print('the client alone')\n")
        done = subprocess.run([sys.executable, "-c", script], text=True, capture_output=True)
        self.assertEqual(done.stdout, "the client alone\n", done.stderr)


class Running(unittest.IsolatedAsyncioTestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "run").mkdir(mode=0o700)
        os.environ["XDG_RUNTIME_DIR"] = str(self.folder / "run")
        self.addCleanup(os.environ.pop, "XDG_RUNTIME_DIR")
        shutil.copytree(EXAMPLES / "pick_and_place", self.folder / "pick")
        self.cell = subprocess.Popen([COMMAND, "run", str(self.folder / "pick"), "--wait", "--pendant", "--port", "0"],
                                     env={**os.environ, "HOME": str(self.folder)}, cwd=self.folder, text=True,
                                     stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.addCleanup(self.cell.stdout.close)
        self.addCleanup(self.cell.wait)
        self.addCleanup(self.cell.kill)
        said = ""
        for line in self.cell.stdout:
            said += line
            if found := re.search(r"http://\S+token=\S+", line):
                self.link = found.group()
                wait_for_cell(self, self.cell, "pick")  # the socket opens after that
                return
        self.fail("the cell printed no link:\n" + said)

    async def test_requests_work_on_both_doors(self):
        self.assertEqual(running_cells(), ["pick"])
        for to in ("pick", self.link):
            async with await connect(to) as cell:
                status = await cell.program()
                self.assertEqual((status["state"], status["passes"]), ("ready", 0))
                health = await cell.ask("health")
                self.assertEqual(set(health), set(await cell.health()))

    async def test_a_refusal_is_an_error_with_its_code(self):
        async with await connect("pick") as cell:
            with self.assertRaises(Error) as caught:
                await cell.control_unload(name="nothing")
            self.assertEqual(caught.exception.code, "unknown-controller")
            self.assertTrue(str(caught.exception))

    async def test_answers_of_requests_side_by_side_find_their_askers(self):
        async with await connect("pick") as cell:
            names = [tag["name"] for tag in (await cell.tags_list())["tags"]]
            answers = await asyncio.gather(*(cell.tags_list(names=[name]) for name in names))
            self.assertEqual([answer["tags"][0]["name"] for answer in answers], names)

    async def test_tags_change_and_a_listener_hears_it(self):
        async with await connect(self.link) as cell, await connect("pick") as other:
            heard = []

            async def listen():
                async for event in cell.listen():
                    heard.append(event["event"])
                    if event["event"] == "tags" and "Vacuum" in str(event):
                        return

            listening = asyncio.create_task(listen())
            await asyncio.sleep(0)
            await other.tags_set(name="Vacuum", value=True)
            await asyncio.wait_for(listening, 30)
            self.assertTrue((await cell.tags_list(names=["Vacuum"]))["tags"][0]["value"])

    async def test_a_stream_ends_with_its_reader(self):
        async with await connect("pick") as cell:
            seen = 0
            async for message in cell.stream("watch", name="joint_states", rate=100):
                self.assertIn("position", message)
                seen += 1
                if seen == 3:
                    break
            self.assertEqual((await cell.program())["state"], "ready")

    async def test_a_held_key_moves_the_robot_and_its_end_stops_it(self):
        async with await connect(self.link) as cell:
            await cell.session_take()

            async def elbow():
                async for state in cell.states(rate=60):
                    return state["time"], state["arm/shoulder_pan_joint/position"]

            _, before = await elbow()
            await cell.hold_key(0.4, mode="joint", axis=0, direction=1, speed=0.2)
            _, after = await elbow()
            self.assertGreater(after, before + 0.001)

            async def at_rest():
                last = None
                async for state in cell.states(rate=60):
                    now = state["arm/shoulder_pan_joint/position"]
                    if last is not None and abs(now - last) < 1e-9:
                        return
                    last = now

            await asyncio.wait_for(at_rest(), 30)

    async def test_a_cell_that_does_not_run_is_named_with_those_that_do(self):
        with self.assertRaisesRegex(OSError, "no cell 'pikc' of this user runs .running: pick."):
            await connect("pikc")

    async def test_states_and_keys_need_the_link(self):
        async with await connect("pick") as cell:
            with self.assertRaises(ValueError):
                await cell.hold_key(1, axis=0)
            with self.assertRaises(ValueError):
                async for _ in cell.states():
                    pass

    async def test_the_end_of_the_cell_ends_every_request(self):
        cell = await connect("pick")
        waiting = asyncio.create_task(anext(aiter(cell.stream("program.watch"))))
        await waiting
        stream = cell.stream("watch", name="joint_states", rate=1)
        await anext(stream)
        self.cell.send_signal(signal.SIGKILL)
        with self.assertRaises(Closed):
            async for _ in stream:
                pass
        with self.assertRaises(Closed):
            await cell.program()
        await cell.close()

    async def test_a_wrong_token_is_refused(self):
        with self.assertRaises(Closed):
            await connect(self.link + "0")
        with self.assertRaises(ValueError):
            await connect(self.link.split("?")[0])

    async def test_numbers_that_json_does_not_have_are_refused_before_they_are_sent(self):
        async with await connect("pick") as cell:
            for value in (float("nan"), float("inf"), object()):
                with self.assertRaises((ValueError, TypeError)):
                    await asyncio.wait_for(cell.ask("tags.set", name="Vacuum", value=value), 10)
            self.assertEqual((await cell.program())["state"], "ready")

    async def test_what_would_end_the_connection_is_refused_before_it_is_sent(self):
        for to in ("pick", self.link):
            async with await connect(to) as cell:
                with self.assertRaisesRegex(ValueError, "tags.set has 1048.* bytes"):
                    await cell.tags_set(name="V" * 2**20, value=True)
                self.assertIn("state", await cell.program())

    async def test_an_argument_never_replaces_the_number_of_a_request(self):
        async with await connect("pick") as cell:
            answer = await asyncio.wait_for(cell.ask("tags.list", id=12345), 60)
            self.assertIn("tags", answer)

    async def test_a_rate_of_nothing_is_refused(self):
        async with await connect(self.link) as cell:
            for rate in (0, -1, float("nan")):
                with self.assertRaisesRegex(ValueError, "it must be above 0"):
                    await anext(cell.states(rate=rate))

    async def test_each_reader_gets_an_error_of_its_own(self):
        async def read_on(events):
            async for _ in events:
                pass

        async with await connect(self.link) as cell:
            waiting = asyncio.gather(read_on(cell.listen()), read_on(cell.listen()), return_exceptions=True)
            await cell.program()
            self.cell.kill()
            errors = await waiting
            for _ in range(2):
                try:
                    await cell.program()
                except Closed as error:
                    errors.append(error)
            self.assertEqual(len({id(error) for error in errors if isinstance(error, Closed)}), len(errors))

    async def test_a_killed_cell_is_not_among_those_that_run(self):
        self.cell.kill()
        self.cell.wait()
        self.assertTrue((self.folder / "run/polyarm/pick.sock").exists())
        self.assertEqual(running_cells(), [])
        with self.assertRaisesRegex(FileNotFoundError, r"no cell 'pick' of this user runs \(running: none\)"):
            await connect("pick")

    async def test_numpy_values_are_sent_as_numbers(self):
        import numpy as np
        async with await connect("pick") as cell:
            await cell.tags_set(name="Feed", value=np.float32(2))
            self.assertEqual((await cell.tags_list(names=["Feed"]))["tags"][0]["value"], 2)

    async def test_an_address_that_is_no_pendant_is_named(self):
        for answer in (b"", b"SSH-2.0\r\n", b"\xff\r\n\r\n", b"HTTP/1.1 200 OK\r\n\r\n"):
            async def other(reader, writer, answer=answer):
                await reader.readuntil(b"\r\n\r\n")
                writer.write(answer)
                writer.close()

            async with await asyncio.start_server(other, "127.0.0.1", 0) as server:
                port = server.sockets[0].getsockname()[1]
                with self.assertRaisesRegex(Closed, f"127.0.0.1:{port} does not|refuses"):
                    await asyncio.wait_for(connect(f"http://127.0.0.1:{port}/?token=x"), 10)

    async def test_the_example_of_the_page_runs(self):
        page = (SOURCE / "docs/python.md").read_text()
        code = re.search(r"^```python run=client\n(.*?)^```", page, re.M | re.S).group(1)
        names = {}
        exec(compile(code, "docs/python.md", "exec"), names)
        await asyncio.wait_for(names["main"](self.link), 120)

    def test_it_imports_without_the_compiled_module(self):
        folder = self.folder / "alone" / "polyarm"
        folder.mkdir(parents=True)
        for name in ("client.py", "requests.py", "errors.py"):
            shutil.copy(SOURCE / "python/polyarm" / name, folder)
        done = subprocess.run([sys.executable, "-c", "import polyarm.client"], env={"PYTHONPATH": str(folder.parent)},
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    unittest.main()
