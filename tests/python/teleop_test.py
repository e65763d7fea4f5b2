"""One arm leads another in a running cell: from a program and from the terminal."""
import asyncio
import os
import pathlib
import pty
import shutil
import signal
import subprocess
import tempfile
import unittest
import unittest.mock

import numpy as np
from polyarm.client import connect
from polyarm.errors import Error
from support import COMMAND, EXAMPLES, wait_for_cell

CELL = """polyarm: cell/1
rate: 250
controllers: controllers.yaml
robots:
  leader: {model: r6bot.urdf, hardware: mock, at: [0, 3, 0]}
  arm: {model: r6bot.urdf, hardware: mock}
teleop:
  pair: {leader: leader, follower: arm, match: relative}
"""
JOINTS = [f"joint_{i}" for i in range(1, 7)]
CONTROLLERS = f"""controller_manager:
  ros__parameters:
    hand: {{type: forward_command_controller/ForwardCommandController}}
hand:
  ros__parameters: {{joints: [{', '.join(f'leader/{joint}' for joint in JOINTS)}], interface_name: position}}
"""


SERVOS = """polyarm: cell/1
rate: 100
robots:
  leader: {model: so101.urdf, hardware: feetech_fake, at: [0, -1, 0], on_fault: group, parameters: {by_hand: true}}
  arm: {model: so101.urdf, hardware: feetech_fake}
teleop:
  pair: {leader: leader, follower: arm}
"""


class RunningCell(unittest.IsolatedAsyncioTestCase):
    def start(self, text, model, **files):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "run").mkdir(mode=0o700)
        environment = unittest.mock.patch.dict(os.environ, XDG_RUNTIME_DIR=str(self.folder / "run"), HOME=str(self.folder))
        environment.start()
        self.addCleanup(environment.stop)
        cell = self.folder / "led"
        cell.mkdir()
        (cell / "cell.yaml").write_text(text)
        for name, content in files.items():
            (cell / f"{name}.yaml").write_text(content)
        shutil.copy(EXAMPLES / model, cell)
        says = open(self.folder / "says.txt", "w")
        self.addCleanup(says.close)
        self.cell = subprocess.Popen([COMMAND, "run", str(cell)], cwd=self.folder, text=True, stdin=subprocess.DEVNULL,
                                     stdout=says, stderr=says)
        self.addCleanup(self.cell.wait)
        self.addCleanup(self.cell.kill)
        wait_for_cell(self, self.cell, "led", self.folder / "says.txt")

    async def until(self, client, state):
        while True:
            pair = (await client.ask("teleop"))["pairs"][0]
            if pair["state"] == state:
                return pair
            await asyncio.sleep(0.02)


class LeadingServos(RunningCell):
    """The real driver on a real wire, with simulated servos."""

    def setUp(self):
        self.start(SERVOS, "so101/so101.urdf")

    async def test_a_leader_without_torque_leads(self):
        async with await connect("led") as client, await connect("led") as other:
            commands = [command["name"] for command in (await client.ask("interfaces"))["commands"]]
            self.assertTrue(commands and all(name.startswith("arm/") for name in commands), commands)
            holding = asyncio.create_task(other.hold_clutch(600))
            await self.until(client, "following")
            holding.cancel()
            await asyncio.gather(holding, return_exceptions=True)
            await self.until(client, "waiting")


class Leading(RunningCell):
    def setUp(self):
        self.start(CELL, "r6bot/r6bot.urdf", controllers=CONTROLLERS)

    async def positions(self, client, robot):
        states = {state["name"]: state["value"] for state in (await client.ask("interfaces"))["states"]}
        return np.array([states[f"{robot}/{joint}/position"] for joint in JOINTS])

    async def lead(self, client, to):
        """Moves the hand there, slowly enough for the follower."""
        begin = await self.positions(client, "leader")
        for k in range(1, 41):
            values = begin + (np.asarray(to) - begin) * k / 40
            await client.ask("send", to="hand", message={"data": values.tolist()})
            await asyncio.sleep(0.02)

    async def test_a_program_holds_the_clutch(self):
        async with await connect("led") as client, await connect("led") as other:
            begin = await self.positions(client, "arm")
            await self.lead(client, [0.1] * 6)
            np.testing.assert_allclose(await self.positions(client, "arm"), begin, atol=1e-9)
            holding = asyncio.create_task(other.hold_clutch(600))
            await self.until(client, "following")
            await self.lead(client, [0.3] * 6)
            while np.abs(await self.positions(client, "arm") - begin - 0.2).max() > 0.01:
                await asyncio.sleep(0.05)
            holding.cancel()
            await asyncio.gather(holding, return_exceptions=True)
            await self.until(client, "waiting")
            with self.assertRaises(Error) as refused:
                await client.ask("teleop", pair="nobody", hold=0.2)
            self.assertEqual(refused.exception.code, "unknown-pair")

    async def test_a_key_at_a_terminal_holds_it_and_a_killed_terminal_does_not(self):
        async with await connect("led") as client:
            process, terminal = pty.fork()
            if process == 0:
                os.execve(COMMAND, [COMMAND, "lead", "--hold", "1", "--first", "2"], {**os.environ, "TERM": "xterm"})
            self.addCleanup(os.close, terminal)

            async def press():
                while True:
                    os.write(terminal, b" ")
                    await asyncio.sleep(0.1)

            drain = asyncio.create_task(asyncio.to_thread(self.drain, terminal))
            pressing = asyncio.create_task(press())
            await self.until(client, "following")
            pressing.cancel()
            await self.until(client, "waiting")  # the key is released
            pressing = asyncio.create_task(press())
            await self.until(client, "following")
            os.kill(process, signal.SIGKILL)
            pressing.cancel()
            await self.until(client, "waiting")
            await asyncio.to_thread(os.waitpid, process, 0)
            await drain

    @staticmethod
    def drain(terminal):
        try:
            while os.read(terminal, 4096):
                pass
        except OSError:  # it is closed
            pass


if __name__ == "__main__":
    unittest.main()
