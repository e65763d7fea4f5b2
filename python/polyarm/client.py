"""An asyncio client of a running cell: requests, streams, events, measured states, jogging.

    from polyarm.client import connect

    async with await connect("http://localhost:8765/?token=...") as cell:   # or connect("r6bot"): the local socket
        status = await cell.program()
        async for state in cell.states(rate=30):
            print(state["arm/tcp/z"])

The standard library is enough; the compiled module is not imported. docs/python.md has examples.
"""
from __future__ import annotations

import asyncio
import base64
import errno
import hashlib
import itertools
import json
import os
import socket
import ssl
import struct
import urllib.parse
from collections.abc import AsyncIterator
from typing import Any

from .errors import Error
from .requests import Requests

__all__ = ["CellClient", "Closed", "connect", "running_cells"]

_BEAT_S = 0.05
_MOST_WAITING = 1000  # events, answers or frames that a slow reader may leave; then the oldest are dropped
_LARGEST_MESSAGE = 64 * 2**20
_LARGEST_REQUEST = 2**20  # bytes; a larger one would end the connection (docs/bounds.md)
_TEXT, _BINARY, _CLOSE, _PING, _PONG = 1, 2, 8, 9, 10


class Closed(ConnectionError):
    """The connection has ended."""


def _folder() -> str:
    """Where cells of this user have their sockets."""
    run = os.environ.get("XDG_RUNTIME_DIR")
    return os.path.join(run, "polyarm") if run else f"/tmp/polyarm-{os.getuid()}"


def running_cells() -> list[str]:
    """The names of this user's cells that take connections at their local socket."""
    try:
        return sorted(name[:-5] for name in os.listdir(_folder()) if name.endswith(".sock") and _answers(name))
    except FileNotFoundError:
        return []


def _answers(name: str) -> bool:
    """False: the socket is the rest of a cell that was killed."""
    with socket.socket(socket.AF_UNIX) as probe:
        probe.setblocking(False)
        return probe.connect_ex(os.path.join(_folder(), name)) in (0, errno.EAGAIN)


async def connect(to: str, name: str = "a Python program", fingerprint: str | None = None) -> CellClient:
    """Connects to a cell.

    `to`: the pendant's link with its token; or the name of a cell of this user, or the path of its socket. States, events
    of the pendant and jogging with a key need the link. `fingerprint`: of the certificate of an https link, as the
    terminal prints it. Raises OSError, Closed.
    """
    if "://" in to:
        channel: _Channel = await _WebSocket.open(to, fingerprint)
    else:
        path = to if "/" in to else os.path.join(_folder(), to + ".sock")
        try:
            channel = _Lines(*await asyncio.open_unix_connection(path, limit=_LARGEST_MESSAGE))
        except (FileNotFoundError, ConnectionRefusedError):
            names = ", ".join(running_cells()) or "none"
            raise FileNotFoundError(errno.ENOENT, f"no cell {to!r} of this user runs (running: {names})", path) from None
    client = CellClient(channel)
    if "://" in to:
        try:
            await client.session_hello(name=name)
        except BaseException:
            await client.close()
            raise
    return client


class _Channel:
    """Carries messages: texts, and of a WebSocket bytes as well."""

    frames = False

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._reader, self._writer = reader, writer

    async def send(self, text: str) -> None:
        raise NotImplementedError

    async def receive(self) -> str | bytes:
        raise NotImplementedError

    async def close(self) -> None:
        self._writer.close()
        try:
            await self._writer.wait_closed()
        except OSError:
            pass


class _Lines(_Channel):
    """The local socket: one JSON object per line."""

    async def send(self, text: str) -> None:
        self._writer.write(text.encode() + b"\n")
        await self._writer.drain()

    async def receive(self) -> str:
        line = await self._reader.readline()
        if not line:
            raise Closed("the cell has closed the connection")
        return line.decode()


class _WebSocket(_Channel):
    """The pendant's port: RFC 6455, client side, without extensions."""

    frames = True

    @classmethod
    async def open(cls, link: str, fingerprint: str | None) -> _WebSocket:
        parts = urllib.parse.urlsplit(link)
        tokens = urllib.parse.parse_qs(parts.query).get("token")
        if not tokens or not parts.hostname:
            raise ValueError("the link has no token: copy it whole, as polyarm prints it")
        tls = _tls(fingerprint) if parts.scheme == "https" else None
        reader, writer = await asyncio.open_connection(parts.hostname, parts.port, ssl=tls, limit=_LARGEST_MESSAGE)
        if tls and fingerprint:
            _require_fingerprint(writer, fingerprint)  # before the token is sent
        key = base64.b64encode(os.urandom(16)).decode()
        writer.write("\r\n".join([
            "GET /ws HTTP/1.1", f"Host: {parts.netloc}", "Upgrade: websocket", "Connection: Upgrade",
            "Sec-WebSocket-Version: 13", f"Sec-WebSocket-Key: {key}", f"Authorization: Bearer {tokens[0]}", "", ""]).encode())
        try:
            head = (await reader.readuntil(b"\r\n\r\n")).decode()
        except (asyncio.IncompleteReadError, asyncio.LimitOverrunError, UnicodeDecodeError):
            writer.close()
            raise Closed(f"{parts.netloc} does not answer as a pendant: copy the whole link, with http or https as printed") from None
        expected = base64.b64encode(hashlib.sha1((key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11").encode()).digest()).decode()
        if " 101 " not in head.split("\r\n")[0] or expected not in head:
            writer.close()
            raise Closed("the pendant's port refuses the connection: " + head.split("\r\n")[0])
        return cls(reader, writer)

    async def send(self, text: str) -> None:
        await self._put(text.encode(), _TEXT)

    async def _put(self, data: bytes, kind: int) -> None:
        size = len(data)
        head = bytes([0x80 | kind])
        if size < 126:
            head += bytes([0x80 | size])
        elif size < 65536:
            head += bytes([0x80 | 126]) + struct.pack(">H", size)
        else:
            head += bytes([0x80 | 127]) + struct.pack(">Q", size)
        mask = os.urandom(4)
        repeated = (mask * (size // 4 + 1))[:size]
        masked = (int.from_bytes(data, "big") ^ int.from_bytes(repeated, "big")).to_bytes(size, "big") if size else b""
        self._writer.write(head + mask + masked)
        await self._writer.drain()

    async def receive(self) -> str | bytes:
        kind, data = 0, b""
        while True:
            first, second = await self._read(2)
            size = second & 0x7F
            if size >= 126:
                size = int.from_bytes(await self._read(2 if size == 126 else 8), "big")
            if size + len(data) > _LARGEST_MESSAGE:
                raise Closed("a message is too large")
            part = await self._read(size)
            code = first & 0x0F
            if code == _PING:
                await self._put(part, _PONG)
            elif code == _CLOSE:
                reason = part[2:].decode(errors="replace") or "no reason given"
                raise Closed(f"closed by the cell: {reason} (code {int.from_bytes(part[:2], 'big')})")
            elif code != _PONG:
                kind, data = kind or code, data + part
                if first & 0x80:
                    return data if kind == _BINARY else data.decode()

    async def _read(self, count: int) -> bytes:
        try:
            return await self._reader.readexactly(count)
        except asyncio.IncompleteReadError:
            raise Closed("the cell has closed the connection") from None


def _tls(fingerprint: str | None) -> ssl.SSLContext:
    context = ssl.create_default_context()
    if fingerprint:  # it is compared instead: no authority has signed it
        context.check_hostname = False
        context.verify_mode = ssl.CERT_NONE
    return context


def _require_fingerprint(writer: asyncio.StreamWriter, fingerprint: str) -> None:
    there = hashlib.sha256(writer.get_extra_info("ssl_object").getpeercert(binary_form=True)).hexdigest()
    if there.upper() != fingerprint.replace(":", "").upper():
        writer.close()
        raise Closed("the certificate has another fingerprint")


class _Mailbox:
    """What has come for one reader; the oldest are dropped when it is slow."""

    def __init__(self, most: int = _MOST_WAITING) -> None:
        self._queue: asyncio.Queue[Any] = asyncio.Queue(most)
        self.dropped = 0

    def put(self, item: Any) -> None:
        if self._queue.full():
            self._queue.get_nowait()
            self.dropped += 1
        self._queue.put_nowait(item)

    async def get(self) -> Any:
        item = await self._queue.get()
        if isinstance(item, BaseException):
            raise _anew(item)
        return item


class CellClient(Requests):
    """A connection to a cell. It has a method for each request (`await cell.control_hold()`), made from the list of
    requests; `ask` takes the request's name. A refusal raises polyarm.errors.Error with its code."""

    def __init__(self, channel: _Channel) -> None:
        self._channel = channel
        self._ids = itertools.count(1)
        self._answers: dict[int, _Mailbox] = {}
        self._listeners: set[_Mailbox] = set()
        self._watchers: set[_Mailbox] = set()
        self._fields: list[str] = []
        self._closed: BaseException | None = None
        self.latest: dict[str, dict[str, Any]] = {}  #: the newest event of each kind, as docs/pendant.md lists them
        self._reading = asyncio.create_task(self._read())

    async def __aenter__(self) -> CellClient:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    async def close(self) -> None:
        """Ends the connection; every stream ends with Closed."""
        self._reading.cancel()
        await asyncio.gather(self._reading, return_exceptions=True)
        await self._channel.close()

    async def ask(self, request: str, **arguments: Any) -> Any:
        """The last answer to a request of docs/requests.md. Raises Error, Closed."""
        return await self._ask(request, arguments)

    async def _ask(self, request: str, arguments: dict[str, Any]) -> Any:
        number, box = await self._send(request, arguments)
        try:
            while True:
                answer = await box.get()
                if not answer.get("more"):
                    return _result(answer)
        finally:
            self._answers.pop(number, None)

    async def stream(self, request: str, **arguments: Any) -> AsyncIterator[Any]:
        """Every answer to a request that is answered again and again: watch, program.watch, events, a goal. Leave it with
        `break` or close the generator; the cell is then asked to end it, where that is possible."""
        number, box = await self._send(request, arguments)
        more = True
        try:
            while more:
                answer = await box.get()
                more = answer.get("more", False)
                yield _result(answer)
        finally:
            self._answers.pop(number, None)
            if more and self._closed is None and self._channel.frames:
                await self._channel.send(json.dumps({"request": "session.end", "of": number}))

    async def listen(self) -> AsyncIterator[dict[str, Any]]:
        """What happens from now on. With the pendant's link: its events (status, tags, program, alarm ...). On the local
        socket: the answers to the request `events`."""
        if not self._channel.frames:
            async for batch in self.stream("events"):
                for event in batch if isinstance(batch, list) else [batch]:
                    yield event
            return
        box = _Mailbox()
        self._listeners.add(box)
        try:
            while True:
                yield await box.get()
        finally:
            self._listeners.discard(box)

    async def states(self, rate: float = 30) -> AsyncIterator[dict[str, float]]:
        """Measured and commanded values by name, and "time" (s of cell time), at most `rate` (60) times a second. Needs the
        pendant's link. A slow reader gets the newest values."""
        self._need_link("states")
        if not rate > 0:
            raise ValueError(f"rate is {rate}; it must be above 0")
        box = _Mailbox(1)
        self._watchers.add(box)
        try:
            await self.session_watch(rate=rate)
            while True:
                yield self._decoded(await box.get())
        finally:
            self._watchers.discard(box)
            if not self._watchers and self._closed is None:
                await self._channel.send(json.dumps({"request": "session.watch", "rate": 0}))

    async def hold_key(self, seconds: float, **arguments: Any) -> None:
        """Holds a jog key for `seconds`: jog.begin with `arguments`, a heartbeat every 50 ms, jog.end. The robot stops by
        itself when the heartbeats end, whatever happens to this program. Needs the pendant's link and control
        (session_take())."""
        self._need_link("hold_key")
        number = (await self.ask("jog.begin", **arguments))["jog"]
        end = asyncio.get_running_loop().time() + seconds
        try:
            while (left := end - asyncio.get_running_loop().time()) > 0:
                await self._channel.send(json.dumps({"request": "jog.beat", "jog": number}))
                await asyncio.sleep(min(_BEAT_S, left))
        finally:
            await self.ask("jog.end", jog=number)

    async def hold_clutch(self, seconds: float, pair: str | None = None) -> None:
        """Holds the clutch of a leader and its follower for `seconds`, and releases it. The follower stops by itself when
        this program ends or hangs. Needs control (session_take()) at the pendant's port."""
        end = asyncio.get_running_loop().time() + seconds
        try:
            while (left := end - asyncio.get_running_loop().time()) > 0:
                await self.ask("teleop", pair=pair, hold=0.3)
                await asyncio.sleep(min(_BEAT_S, left))
        finally:
            await self.ask("teleop", pair=pair, hold=0)

    def _need_link(self, what: str) -> None:
        if not self._channel.frames:
            raise ValueError(f"{what} needs the pendant's link: run the cell with --pendant and connect to what it prints")

    async def _send(self, request: str, arguments: dict[str, Any]) -> tuple[int, _Mailbox]:
        if self._closed is not None:
            raise _anew(self._closed)
        number, box = next(self._ids), _Mailbox()
        given = {key: value for key, value in arguments.items() if value is not None}
        try:
            line = json.dumps({**given, "request": request, "id": number}, allow_nan=False, default=_plain)
        except ValueError:
            raise ValueError(f"an argument of {request} contains NaN or infinity, which JSON cannot say") from None
        if len(line) >= _LARGEST_REQUEST:
            raise ValueError(f"{request} has {len(line)} bytes; a request has fewer than {_LARGEST_REQUEST}")
        self._answers[number] = box
        try:
            await self._channel.send(line)
        except BaseException:
            del self._answers[number]
            raise
        return number, box

    async def _read(self) -> None:
        error: BaseException = Closed("the connection was closed")
        try:
            while True:
                self._take(await self._channel.receive())
        except (OSError, ValueError, Closed) as e:
            error = e if isinstance(e, Closed) else Closed(str(e))
        finally:
            self._closed = error
            for box in [*self._answers.values(), *self._listeners, *self._watchers]:
                box.put(error)

    def _take(self, message: str | bytes) -> None:
        if isinstance(message, bytes):
            for box in self._watchers:
                box.put(message)
            return
        fields = json.loads(message)
        if "event" in fields:
            if fields["event"] == "layout":
                self._fields = [field["name"] for field in fields["fields"]]
            self.latest[fields["event"]] = fields
            for box in self._listeners:
                box.put(fields)
        elif (waiting := self._answers.get(fields.get("id"))) is not None:
            waiting.put(fields)

    def _decoded(self, frame: bytes) -> dict[str, float]:
        count = min(len(self._fields), (len(frame) - 16) // 4)
        values = struct.unpack_from(f"<{count}f", frame, 16)
        return {"time": struct.unpack_from("<d", frame, 8)[0], **dict(zip(self._fields, values))}


def _anew(error: BaseException) -> BaseException:
    """The same error for another reader; each one that is raised has a traceback of its own."""
    return type(error)(*error.args)


def _plain(value: Any) -> Any:
    """NumPy values as JSON."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} has no form in JSON")


def _result(answer: dict[str, Any]) -> Any:
    if answer.get("ok"):
        return answer.get("result")
    raise Error([{"severity": "error", "where": "", "advice": "", **answer.get("error", {"code": "unknown", "what": "refused"})}])
