#!/usr/bin/env python3
"""Late cycles of a cell that so many clients watch, beside those of an empty loop: pendant_clients.py POLYARM CLIENTS SECONDS.

The clients take 30 state frames a second each and all events, and read them without looking at them, in this one process. It
cannot tell the cell's lateness from what the clients themselves cost a machine of few cores."""
import json
import os
import re
import selectors
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time


def text_frame(message):
    data = json.dumps(message).encode()
    head = bytes([0x81, 0x80 | len(data)]) if len(data) < 126 else bytes([0x81, 0x80 | 126]) + struct.pack(">H", len(data))
    return head + b"\0\0\0\0" + data


def watcher(port, token):
    out = socket.create_connection(("127.0.0.1", port))
    lines = ["GET /ws HTTP/1.1", f"Host: localhost:{port}", f"Authorization: Bearer {token}", "Upgrade: websocket",
             "Connection: Upgrade", "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: AAECAwQFBgcICQoLDA0ODw==", "", ""]
    out.sendall("\r\n".join(lines).encode())
    while b"\r\n\r\n" not in out.recv(4096):
        pass
    out.sendall(text_frame({"id": 1, "request": "session.hello", "name": "bench"}))
    out.sendall(text_frame({"id": 2, "request": "session.watch", "rate": 30}))
    out.setblocking(False)
    return out


def main():
    polyarm, clients, seconds = sys.argv[1], int(sys.argv[2]), sys.argv[3]
    with tempfile.TemporaryDirectory() as home:
        cell = subprocess.Popen([polyarm, "run", "examples/pick_and_place", "--pendant", "--port", "0", "--no-socket", "--seconds", seconds],
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env={**os.environ, "XDG_RUNTIME_DIR": home})
        for line in cell.stdout:
            if link := re.search(r"pendant: http://localhost:(\d+)/\?token=(\S+)", line):
                break
        said = []
        rest = threading.Thread(target=lambda: said.extend(cell.stdout))
        rest.start()
        ready = selectors.DefaultSelector()
        for _ in range(clients):
            ready.register(watcher(int(link[1]), link[2]), selectors.EVENT_READ)
            time.sleep(0.01)
        while cell.poll() is None:
            for key, _ in ready.select(0.2) if clients else []:
                if not key.fileobj.recv(1 << 18):
                    ready.unregister(key.fileobj)
            if not clients:
                time.sleep(0.2)
        rest.join()
        print(clients, "clients:", re.search(r"control loop\s+(.*)", "".join(said))[1])


main()
