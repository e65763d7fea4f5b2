"""What the tests of the Python module share. POLYARM_COMMAND and POLYARM_SOURCE come from CMake."""
import os
import pathlib
import socket
import tempfile
import time

COMMAND = os.environ["POLYARM_COMMAND"]
SOURCE = pathlib.Path(os.environ["POLYARM_SOURCE"])
EXAMPLES = SOURCE / "examples"


def forward_cell(test, driver="mock"):
    """A cell of six axes with a forward controller of positions; the path of its file."""
    folder = pathlib.Path(tempfile.mkdtemp())
    test.addCleanup(lambda: __import__("shutil").rmtree(folder))
    joints = ", ".join(f"joint_{i}" for i in range(1, 7))
    (folder / "controllers.yaml").write_text(
        "controller_manager:\n  ros__parameters:\n    update_rate: 500\n"
        "    forward: {type: forward_command_controller/ForwardCommandController}\n"
        f"forward:\n  ros__parameters: {{joints: [{joints}], interface_name: position}}\n")
    (folder / "cell.yaml").write_text(
        f"polyarm: cell/1\nrobots: {{arm: {{model: {EXAMPLES}/r6bot/r6bot.urdf, hardware: {driver}}}}}\n"
        "controllers: controllers.yaml\n")
    return folder / "cell.yaml"


def wait_for_cell(test, process, name, output=None):
    """Waits until the local socket of a cell takes connections; its file is there a little earlier. `output`: the file
    that the cell prints to, shown if it ends."""
    path = os.path.join(os.environ["XDG_RUNTIME_DIR"], "polyarm", name + ".sock")
    while True:
        if process.poll() is not None:
            test.fail("the cell has ended: " + (output.read_text() if output else f"exit code {process.returncode}"))
        with socket.socket(socket.AF_UNIX) as probe:
            try:
                return probe.connect(path)
            except (FileNotFoundError, ConnectionRefusedError):
                time.sleep(0.01)
