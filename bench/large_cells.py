#!/usr/bin/env python3
"""How the start of a cell grows with its robots, and a run in lock-step with its queued moves.

bench/large_cells.py [POLYARM]      (default: build/release/polyarm)

For 10 to 1,000 UR5e on mock hardware: processor time of the whole process (start, three cycles, end) and its
largest memory. For 100 to 5,000 short lines of one UR5e, with and without blends, under --fast: processor time
and memory until the program ends. `per` is the figure divided by the number; where it stays the same, the cost
is linear. Each figure is the least of three runs. It cannot show how late cycles are on the wall clock.
"""
import os
import subprocess
import sys
import tempfile


def measure(command):
    """Processor time in s and the largest memory in MB of the least of three runs."""
    runs = []
    for _ in range(3):
        child = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(child.pid, 0)
        if status != 0:
            raise SystemExit(f"{' '.join(command)} failed")
        runs.append((usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024))
    return min(runs)


def many_robots(folder, count):
    side = int(count**0.5) + 1
    with open(folder + "/cell.yaml", "w") as cell:
        cell.write("polyarm: cell/1\nrobots:\n")
        for i in range(count):
            at = f"[{3 * (i % side)}, {3 * (i // side)}, 0]"
            cell.write(f"  r{i}: {{model: universal_robots/ur5e, hardware: mock, at: {at}}}\n")


def many_moves(folder, count, clause):
    with open(folder + "/cell.yaml", "w") as cell:
        cell.write("polyarm: cell/1\nrobots: {arm: {model: universal_robots/ur5e, hardware: mock}}\nprogram: lines.script\n")
    with open(folder + "/lines.script", "w") as program:
        program.write(f"""moveto joints(0, -90deg, 90deg, -90deg, -90deg, 0)
let p = here()
for i in 1 .. {count}
  movel offset(p, z = (i mod 2) * 30mm - 15mm, y = (i mod 7) * 10mm){clause}
end
""")


def main():
    polyarm = sys.argv[1] if len(sys.argv) > 1 else "build/release/polyarm"
    run = [polyarm, "run", "--fast", "--json", "--no-socket"]
    print(f"{'':24} {'s':>7} {'ms per':>7} {'MB':>6} {'MB per':>7}")

    def row(name, count, folder, *options):
        time, memory = measure([*run, folder, *options])
        print(f"{count:>6} {name:17} {time:7.2f} {1e3 * time / count:7.2f} {memory:6.0f} {memory / count:7.2f}", flush=True)

    for count in (10, 30, 100, 300, 1000):
        with tempfile.TemporaryDirectory() as folder:
            many_robots(folder, count)
            row("robots", count, folder, "--seconds", "0.003")
    for name, clause in (("lines", ""), ("lines with blends", ", blend 2mm")):
        for count in (100, 1000, 5000):
            with tempfile.TemporaryDirectory() as folder:
                many_moves(folder, count, clause)
                row(name, count, folder)


main()
