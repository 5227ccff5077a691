"""Simulators that start `apex run` and fly with it: a balloon, and a rotorcraft for missions with `sites.geojson`.

Usage: simulator.py APEX PROGRAM            the simulator owns the clock: applications of type foreign-sim
       simulator.py APEX MISSION --pace N   the vehicle of a mission of type realtime, N times as fast as real time
"""

import contextlib
import json
import re
import subprocess
import sys
import threading
import time
from pathlib import Path
from queue import Queue

from rotorcraft import Rotorcraft, places_of

CLIMB_MPS = 5.0
STEP_S = 1.0


class Balloon:
    """Its height, and the command that it carries out."""

    def __init__(self):
        self.height_m = 0.0
        self.command = None
        self.goal_m = 0.0

    def obey(self, effect):
        """Takes one effect of Apex."""
        if "command" in effect:
            self.command = effect["command"]
            self.goal_m = float(re.search(r"-?[\d.]+", effect["form"]).group())
        elif effect.get("withdraw") == self.command:
            self.command = None

    def move(self, seconds):
        """Moves for a while; returns the inputs for Apex."""
        inputs = []
        if self.command is not None:
            way = self.goal_m - self.height_m
            most = CLIMB_MPS * seconds
            self.height_m += max(-most, min(most, way))
            if self.height_m == self.goal_m:
                inputs.append({"acknowledge": self.command})
                self.command = None
        inputs.append({"measurement": "(height balloon)", "value": {"pdl": f"{self.height_m:g}m"}})
        return inputs

    def said_at(self, now, to):
        """Events from outside between two instants."""
        return [{"event": "(time to land)"}] if now < 100 <= to else []

    def state(self):
        """Where it is, as text."""
        return f"{self.height_m:g} m"


def vehicle_of(program):
    """The vehicle that a program flies: the first agent of a mission in a folder, or the balloon."""
    mission = Path(program) / "mission.pdl"
    if not mission.is_file():
        return Balloon()
    agent = re.search(r"\(agent\s+([^\s)]+)", mission.read_text()).group(1)
    return Rotorcraft(agent, places_of(program))


def own_clock(command, program):
    """Steps Apex at the simulator's clock."""
    apex = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    greeting = json.loads(apex.stdout.readline())
    print("agents:", *greeting["agents"], "- says:", *greeting["say"])
    vehicle, now, answer = vehicle_of(program), 0.0, {"wake": 0}
    while "end" not in answer:
        # Never farther than Apex wants to be stepped, and never farther than a step.
        wake = answer["wake"]
        to = now + STEP_S if wake is None or wake <= now else min(now + STEP_S, wake)
        inputs = vehicle.move(to - now) + vehicle.said_at(now, to)
        print(json.dumps({"advance": to, "inputs": inputs}), file=apex.stdin, flush=True)
        answer, now = json.loads(apex.stdout.readline()), to
        if "error" in answer:
            sys.exit(answer["error"])
        for effect in answer["effects"]:
            print(f"{now:g} s, {vehicle.state()}: {json.dumps(effect)}")
            vehicle.obey(effect)
    print("end:", answer["end"], "- says:", *answer.get("say", []))
    return apex.wait()


def real_time(command, program, pace):
    """Runs in parallel with Apex: commands come in its trace, reports go to its standard input."""
    apex = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    trace = Queue()

    def read():
        for line in apex.stdout:
            trace.put(json.loads(line))
        trace.put(None)

    threading.Thread(target=read, daemon=True).start()
    vehicle, before = vehicle_of(program), time.monotonic()
    while True:
        while not trace.empty():
            entry = trace.get()
            if entry is None:
                return apex.wait()
            if entry["kind"] == "command":
                vehicle.obey(entry)
            elif entry["kind"] == "withdraw":
                vehicle.obey({"withdraw": entry["command"]})
            if entry["kind"] != "measurement":
                print(json.dumps(entry))
        time.sleep(STEP_S / pace)
        now = time.monotonic()
        lines = [json.dumps(line) + "\n" for line in vehicle.move((now - before) * pace)]
        before = now
        # The run may be over: the trace holds its end.
        with contextlib.suppress(BrokenPipeError):
            apex.stdin.write("".join(lines))
            apex.stdin.flush()


def main():
    if len(sys.argv) < 3:
        print("usage: simulator.py APEX PROGRAM [--pace FACTOR] [options of apex run]", file=sys.stderr)
        return 2
    program = sys.argv[2]
    command = [sys.argv[1], "run", program]
    if "--pace" in sys.argv[3:]:
        return real_time(command + sys.argv[3:], program, float(sys.argv[sys.argv.index("--pace") + 1]))
    return own_clock(command + sys.argv[3:], program)


if __name__ == "__main__":
    sys.exit(main())
