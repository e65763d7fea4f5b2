#!/usr/bin/env python3
"""Late cycles of a cell that so many clients watch, beside those of an empty loop of its rate in the same process.

    pendant_clients.py POLYARM [--clients 0 20] [--rounds 2] [--seconds 16] [--keep FILE]

A round is a run with each number of clients, in an order drawn anew. The clients take 30 state frames a second each and all
events, and read them without looking at them, in this one process. --keep appends the runs to FILE, which is read first, so that
many short calls are one measurement. Told at the end, of each number of clients: late cycles of all runs, cell : empty loop; the
median of a run's difference in late cycles a minute, with its quartiles; in how many runs the cell was late more often.
It cannot tell the cell's lateness from what the clients themselves cost a machine of few cores: for that the empty loop is there."""
import argparse
import json
import os
import random
import re
import selectors
import socket
import statistics
import struct
import subprocess
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


def run(polyarm, clients, seconds):
    """One cell, watched from its beginning to its end."""
    with tempfile.TemporaryDirectory() as home:
        cell = subprocess.Popen([polyarm, "run", "examples/pick_and_place", "--pendant", "--port", "0", "--no-socket", "--seconds", str(seconds)],
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
        taken = 0
        while cell.poll() is None:
            for key, _ in ready.select(0.2) if clients else []:
                got = key.fileobj.recv(1 << 18)
                taken += len(got)
                if not got:
                    ready.unregister(key.fileobj)
            if not clients:
                time.sleep(0.2)
        rest.join()
        numbers = re.search(r"control loop\s+(\d+) cycles, (\d+) late \(an empty loop beside it: (\d+)\)", "".join(said))
        if not numbers:
            raise SystemExit("the cell did not tell its cycles:\n" + "".join(said))
        cycles, late, empty = map(int, numbers.groups())
        return {"clients": clients, "cycles": cycles, "late": late, "empty": empty, "bytes": taken}


def tell(runs):
    for clients in sorted({each["clients"] for each in runs}):
        mine = [each for each in runs if each["clients"] == clients]
        more = [60_000 * (each["late"] - each["empty"]) / each["cycles"] for each in mine]
        low, middle, high = statistics.quantiles(more, n=4) if len(more) > 1 else more * 3
        print(f"{clients:3d} clients, {len(mine)} runs: {sum(e['late'] for e in mine)} : {sum(e['empty'] for e in mine)} late in all, "
              f"{middle:+.0f} a minute in the median ({low:+.0f} to {high:+.0f}), more in {sum(e['late'] > e['empty'] for e in mine)} runs")


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("polyarm")
    arguments.add_argument("--clients", type=int, nargs="+", default=[0, 20])
    arguments.add_argument("--rounds", type=int, default=2)
    arguments.add_argument("--seconds", type=float, default=16)
    arguments.add_argument("--keep")
    a = arguments.parse_args()
    runs = []
    if a.keep and os.path.exists(a.keep):
        with open(a.keep, encoding="utf-8") as kept:
            runs = [json.loads(line) for line in kept]
    for _ in range(a.rounds):
        for clients in random.sample(a.clients, len(a.clients)):
            runs.append(run(a.polyarm, clients, a.seconds))
            print(runs[-1], flush=True)
            if a.keep:
                with open(a.keep, "a", encoding="utf-8") as kept:
                    kept.write(json.dumps(runs[-1]) + "\n")
    tell(runs)


main()
