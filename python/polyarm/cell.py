"""A simulated cell that this program steps: as fast as the machine allows, and repeatable."""
import difflib
import itertools
import json
import math
import os
import shutil
import tempfile
from collections import namedtuple

import numpy as np

from ._compiled import _polyarm
from .errors import Error, problem as _problem

Event = namedtuple("Event", "time kind text where")

_PIECE = 1000  # cycles
_MOST_CALLS = 1_000_000  # that can be saved


class Saved:
    """A state of a cell, from Cell.save(): what was called since its start. Other processes may have it (pickle)."""

    def __init__(self, time, calls, states):
        self.time, self._calls, self._states = time, calls, states

    def __repr__(self):
        return f"<polyarm.Saved at {self.time:.3f} s, {len(self._calls)} calls>"


class Cell:
    """A whole cell in lock-step: robots, controllers, scene, PLC and program.

    Nothing happens between two calls of step(). The same calls give the same numbers, bit for bit, on the same build and
    machine. Several cells may live in one process. Threads that use one cell take turns, call by call. The files that a run
    writes go to a temporary folder, so that processes share a cell's folder.
    """

    def __init__(self, path, robot="", hardware="", program="", start=False, allow_contact=False, answers=()):
        """`path`: a folder with a cell.yaml, a cell file, a URDF, or a robot of the catalogue. `robot`, `hardware`,
        `program`: as the options of `polyarm run`. `start`: the program begins at once, and the cell ends with it. Else
        it waits for start_program(). Raises Error with everything that is wrong."""
        path = os.fsdecode(path)
        if isinstance(answers, str):
            raise TypeError("answers is a list of texts")
        self._folder = tempfile.mkdtemp(prefix="polyarm_")
        self._process = os.getpid()
        self._ids = itertools.count(1)
        self._calls = []  # since the start: numbers of cycles, and requests
        try:
            self._open = _polyarm.LockStepCell(path, robot, hardware, program, self._folder, not start, allow_contact,
                                               list(answers))
        except BaseException:
            self._remove_folder()
            raise

    @property
    def _cell(self):
        if self._open is None:
            raise Error([_problem("closed", "this cell is closed", "make another Cell")])
        return self._open

    period = property(lambda self: self._cell.period, doc="Seconds of one cycle of the control loop.")
    time = property(lambda self: self._cell.time, doc="Cell time, s.")
    state_names = property(lambda self: self._cell.state_names, doc="Names of state(), in its order.")
    command_names = property(lambda self: self._cell.command_names, doc="Names of command(), in its order.")
    loop_state = property(lambda self: self._cell.loop_state, doc="running, stopping, held, fault or backing.")
    finished = property(lambda self: self._cell.finished, doc="True: the program has ended and the parts are at rest.")

    def step(self, cycles=1):
        """`cycles` of the control loop. Raises Error if the cell has failed, for example by a contact."""
        if cycles < 0:
            raise ValueError("cycles is negative")
        if not math.isfinite(cycles) or cycles != int(cycles):
            raise ValueError(f"{cycles} cycles: a whole number was expected; run(seconds) takes a time")
        left = int(cycles)
        while left > 0:  # in pieces, so that Ctrl-C ends a long run
            piece = min(left, _PIECE)
            self._cell.step(piece)
            self._note(piece)
            left -= piece
        self._raise_failure()

    def run(self, seconds):
        """As many cycles as `seconds` of cell time have."""
        if not math.isfinite(seconds):
            raise ValueError(f"seconds is {seconds}; it must be finite")
        self.step(round(seconds / self.period))

    def reset(self):
        """The cell anew, from its files: time 0, robots at their start, variables as the files say."""
        cell = self._cell
        self._empty_folder()
        self._calls = []
        cell.reset()

    def save(self):
        """The state of the cell, for restore(). Raises Error("too-long") after a million calls without a reset()."""
        if len(self._calls) >= _MOST_CALLS:
            raise Error([_problem("too-long", f"more than {_MOST_CALLS} calls since the start cannot be saved",
                                  "reset the cell from time to time")])
        return Saved(self.time, tuple(self._calls), self.states())

    def restore(self, saved):
        """The cell as it was at save(), bit for bit, also one made by another Cell with the same arguments. Everything
        since the start is repeated, so this takes as long as that took. Raises Error("not-repeatable") if the states differ,
        for example because a file of the cell has changed."""
        self.reset()
        for call in saved._calls:
            if isinstance(call, int):
                for done in range(0, call, _PIECE):
                    piece = min(_PIECE, call - done)
                    self._cell.step(piece)
                    self._note(piece)
            else:
                self._cell.ask(*call)
                self._note(call)
        if self.time != saved.time or not np.array_equal(self.states(), saved._states, equal_nan=True):
            raise Error([_problem("not-repeatable", "the same calls gave other states than those saved",
                                  "restore with the same files, arguments and version")])

    def states(self):
        """The values of all state interfaces, as an array: measured by sensors and drives."""
        return self._cell.states()

    def commands(self):
        """The values of all command interfaces, as an array. NaN: nobody commands it."""
        return self._cell.commands()

    def state(self, name):
        """The value of one state interface: "arm/elbow_joint/position"."""
        return self.states()[self._index(self.state_names, name)]

    def command(self, name):
        """The value of one command interface."""
        return self.commands()[self._index(self.command_names, name)]

    def ask(self, request, follow=False, patience=20.0, **arguments):
        """The answer to a request of docs/requests.md, as in `cell.ask("tags.set", name="Vacuum", value=True)`.

        Cell time goes on until the answer is there, at most `patience` s. `follow`: to the last answer of a goal or a
        move. Raises Error with the code of the refusal; code "no-answer" after `patience`.
        """
        if not 0 <= patience <= 1e9:
            raise ValueError(f"patience is {patience} s; it must be 0 to 1e9")
        number = str(next(self._ids))
        try:
            line = json.dumps({**arguments, "request": request, "id": number}, default=_plain, allow_nan=False)
        except ValueError:
            raise ValueError(f"an argument of {request} contains NaN or infinity, which JSON cannot say") from None
        text = self._cell.ask(line, number, follow, patience)
        self._note((line, number, follow, patience))
        answer = json.loads(text) if text else {"ok": False, "error": {
            "code": "no-answer", "what": f"no answer to {request} within {patience} s of cell time", "advice": "",
            "where": ""}}
        if not answer["ok"]:
            raise Error([{"severity": "error", **answer["error"]}])
        return answer["result"]

    def send(self, to, message):
        """Sends a message to a controller, for example a list of numbers to a forward controller."""
        if isinstance(message, (list, tuple, np.ndarray)):
            message = {"data": [float(value) for value in message]}
        return self.ask("send", to=to, message=message)

    def tag(self, name):
        """The value of a tag or variable."""
        return self.ask("tags.list", names=[name])["tags"][0]["value"]

    def set_tag(self, name, value):
        """Changes a tag or variable."""
        self.ask("tags.set", name=name, value=value)

    def start_program(self, passes=None):
        """Begins the program of the cell. `passes`: its outermost while ends after that many."""
        return self.ask("program.start", **({} if passes is None else {"passes": passes}))

    def run_program(self, passes=None, seconds=600.0):
        """Begins the program and steps until it has ended. Raises Error if it fails, or after `seconds` of cell time.
        Returns its status."""
        self.start_program(passes)
        end = self.time + seconds
        while self.time < end:
            self.run(0.02)
            status = self.ask("program")
            if status["state"] in ("finished", "stopped"):
                return status
            if status["state"] == "failed":
                raise Error([{"severity": "error", **status["problem"]}])
        raise Error([_problem("too-long", f"the program has not ended within {seconds} s of cell time",
                              "give it more seconds, or passes")])

    def events(self):
        """What has happened since the last call, oldest first, at most 10 000: Event(time, kind, text, where)."""
        return [Event(*event) for event in self._cell.take_events()]

    def close(self):
        """Ends the cell and removes its temporary folder."""
        self._open = None
        self._remove_folder()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __del__(self):
        self._remove_folder()

    @staticmethod
    def _index(names, name):
        try:
            return names.index(name)
        except ValueError:
            near = difflib.get_close_matches(str(name), names, 3, 0.5) or names[:8]
            raise KeyError(f"there is no interface '{name}'; there are {', '.join(near)} ...") from None

    def _raise_failure(self):
        code, text = self._cell.failure
        if code:
            raise Error([_problem(code, text)], text)

    def _note(self, call):
        """Remembers a call for save(). Cycles are added to those before."""
        if isinstance(call, int) and self._calls and isinstance(self._calls[-1], int):
            self._calls[-1] += call
        elif len(self._calls) < _MOST_CALLS:
            self._calls.append(call)

    def _empty_folder(self):
        if os.getpid() == self._process:
            shutil.rmtree(self._folder, ignore_errors=True)

    def _remove_folder(self):
        """In a copy of the process (fork), the folder belongs to the original."""
        if getattr(self, "_folder", None) and shutil:
            if os.getpid() == self._process:
                shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = None


def _plain(value):
    """NumPy values as JSON."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} has no form in JSON")
