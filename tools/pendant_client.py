#!/usr/bin/env python3
"""A client of a running cell's pendant: requests, events and state frames, with the standard library alone.

    from pendant_client import Pendant
    with Pendant("http://localhost:8765/?token=...") as cell:
        cell.ask("session.take")
        print(cell.ask("control.override", percent=50))

On the command line: pendant_client.py LINK REQUEST [NAME=VALUE ...] prints the answer as JSON.
"""

import base64
import hashlib
import json
import os
import select
import socket
import ssl
import struct
import sys
import threading
import time
import urllib.parse
import urllib.request

_MAGIC = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10


class Refused(Exception):
    """An answer with ok: false; `error` has code, what, advice, where."""

    def __init__(self, error):
        super().__init__("%s: %s" % (error.get("code"), error.get("what")))
        self.error = error


class WebSocket:
    """RFC 6455, client side, without extensions."""

    def __init__(self, host, port, path, headers=(), timeout=10, tls=None):
        self.socket = socket.create_connection((host, port), timeout=timeout)
        if tls:
            self.socket = tls.wrap_socket(self.socket, server_hostname=host)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._writing = threading.Lock()  # of a TLS connection it is held for reading, too
        self._tls = tls is not None
        key = base64.b64encode(os.urandom(16))
        lines = ["GET %s HTTP/1.1" % path, "Host: %s:%d" % (host, port), "Upgrade: websocket",
                 "Connection: Upgrade", "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: " + key.decode()]
        lines += ["%s: %s" % header for header in headers]
        self.socket.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        head = b""
        while b"\r\n\r\n" not in head:
            got = self.socket.recv(4096)
            if not got:
                break
            head += got
        head, _, self._rest = head.partition(b"\r\n\r\n")
        status = head.split(b"\r\n")[0].decode()
        expected = base64.b64encode(hashlib.sha1(key + _MAGIC).digest())
        if " 101 " not in status or expected not in head:
            self.socket.close()
            raise ConnectionError(status or "closed")

    def _receive(self):
        if not self._tls:
            return self.socket.recv(65536)
        while not self.socket.pending():  # two threads must not use one TLS connection at a time
            if select.select([self.socket], [], [], 1)[0]:
                break
        with self._writing:
            return self.socket.recv(65536)

    def _read(self, count):
        while len(self._rest) < count:
            got = self._receive()
            if not got:
                raise ConnectionError("closed")
            self._rest += got
        out, self._rest = self._rest[:count], self._rest[count:]
        return out

    def send(self, data, kind=TEXT):
        if isinstance(data, str):
            data = data.encode()
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
        with self._writing:
            self.socket.sendall(head + mask + masked)

    def receive(self):
        """(kind, bytes) of the next whole message; pings are answered on the way."""
        kind, data = 0, b""
        while True:
            first, second = self._read(2)
            size = second & 0x7F
            if size == 126:
                size = struct.unpack(">H", self._read(2))[0]
            elif size == 127:
                size = struct.unpack(">Q", self._read(8))[0]
            part = self._read(size)
            code = first & 0x0F
            if code == PING:
                self.send(part, PONG)
            elif code == CLOSE:
                try:
                    self.send(part, CLOSE)
                except OSError:
                    pass
                raise ConnectionError("closed: " + part[2:].decode(errors="replace"))
            elif code != PONG:
                kind, data = kind or code, data + part
                if first & 0x80:
                    return kind, data

    def close(self):
        try:
            self.send(struct.pack(">H", 1000), CLOSE)
        except OSError:
            pass
        self.socket.close()


def tls_to(host, port, fingerprint=None):
    """A TLS context for that server: of the certificate that has the fingerprint ("3A:F1:…", as polyarm prints it),
    else of one that the machine trusts."""
    if not fingerprint:
        return ssl.create_default_context()
    shown = ssl.get_server_certificate((host, port), timeout=10)
    there = hashlib.sha256(ssl.PEM_cert_to_DER_cert(shown)).hexdigest()
    if there.upper() != fingerprint.replace(":", "").upper():
        raise ConnectionError("the certificate of %s has another fingerprint" % host)
    context = ssl.create_default_context(cadata=shown)  # that certificate and no other
    context.check_hostname = False
    return context


class Pendant:
    """A connection to a cell. A thread reads; `events` keeps the newest of each kind, `state()` the newest frame.
    Of an https link `fingerprint` (or POLYARM_FINGERPRINT) is that of the certificate."""

    def __init__(self, link, name="a program", rate=0, on_event=None, fingerprint=None):
        parts = urllib.parse.urlsplit(link)
        self.base = "%s://%s" % (parts.scheme, parts.netloc)
        self._tls = None
        if parts.scheme == "https":
            self._tls = tls_to(parts.hostname, parts.port, fingerprint or os.environ.get("POLYARM_FINGERPRINT"))
        self.token = urllib.parse.parse_qs(parts.query)["token"][0]
        self._socket = WebSocket(parts.hostname, parts.port, "/ws", [("Authorization", "Bearer " + self.token)],
                                 tls=self._tls)
        self._socket.socket.settimeout(None)
        self._condition = threading.Condition()
        self._answers, self._last, self._closed = {}, 0, None
        self._fields, self._frame = [], None
        self.frames = 0
        self.events, self._on_event = {}, on_event
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        self.hello = self.ask("session.hello", name=name)
        if rate:
            self.ask("session.watch", rate=rate)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self._socket.close()
        self._thread.join(2)

    def get(self, path, data=None, method=None):
        """Bytes of a path below /api/."""
        request = urllib.request.Request(self.base + path, data=data, method=method,
                                         headers={"Authorization": "Bearer " + self.token})
        with urllib.request.urlopen(request, timeout=60, context=self._tls) as answer:
            return answer.read()

    def tell(self, request, **arguments):
        """Sends a request; its number."""
        with self._condition:
            self._last += 1
            number = self._last
        self._socket.send(json.dumps({"id": number, "request": request, **arguments}))
        return number

    def answer(self, number, timeout=10):
        """Waits for the last answer to that request; raises Refused."""
        with self._condition:
            if not self._condition.wait_for(lambda: number in self._answers or self._closed, timeout):
                raise TimeoutError("no answer")
            if number not in self._answers:
                raise ConnectionError(self._closed)
            answer = self._answers.pop(number)
        if not answer.get("ok"):
            raise Refused(answer.get("error", {}))
        return answer.get("result")

    def ask(self, request, timeout=10, **arguments):
        return self.answer(self.tell(request, **arguments), timeout)

    def wait(self, condition, timeout=10):
        """Until condition(self) holds, looked at whenever something has come."""
        with self._condition:
            if not self._condition.wait_for(lambda: condition(self) or self._closed, timeout):
                raise TimeoutError("it did not come")

    def state(self):
        """{name: value} of the newest frame, with "time"; None before the first."""
        with self._condition:
            frame, fields = self._frame, self._fields
        if frame is None or not fields:
            return None
        values = struct.unpack_from("<%df" % len(fields), frame, 16)
        return {"time": struct.unpack_from("<d", frame, 8)[0], **dict(zip(fields, values))}

    def jog(self, seconds, **arguments):
        """Holds a key for so long: begin, a heartbeat every 50 ms, end."""
        number = self.ask("jog.begin", **arguments)["jog"]
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._socket.send(json.dumps({"request": "jog.beat", "jog": number}))
            time.sleep(0.05)
        self.ask("jog.end", jog=number)

    def _run(self):
        try:
            while True:
                kind, data = self._socket.receive()
                with self._condition:
                    if kind == BINARY:
                        self._frame = data
                        self.frames += 1
                    else:
                        self._take(json.loads(data))
                    self._condition.notify_all()
        except (OSError, ConnectionError) as error:
            with self._condition:
                self._closed = str(error) or "closed"
                self._condition.notify_all()

    def _take(self, message):
        if "event" in message:
            if message["event"] == "layout":
                self._fields = [field["name"] for field in message["fields"]]
            self.events[message["event"]] = message
            if self._on_event:
                self._on_event(message)
        elif not message.get("more"):
            self._answers[message.get("id")] = message


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    arguments = {}
    for word in sys.argv[3:]:
        name, _, value = word.partition("=")
        try:
            arguments[name] = json.loads(value)
        except ValueError:
            arguments[name] = value
    with Pendant(sys.argv[1], "pendant_client.py") as cell:
        try:
            print(json.dumps(cell.ask(sys.argv[2], **arguments), indent=1))
        except Refused as refused:
            sys.exit("%s (%s)" % (refused, refused.error.get("advice")))


if __name__ == "__main__":
    main()
