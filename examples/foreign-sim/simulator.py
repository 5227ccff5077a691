"""A balloon that owns the clock: starts `apex run` and speaks the protocol of foreign-sim applications with it.

Usage: simulator.py APEX PROGRAM.pdl
"""

import json
import re
import subprocess
import sys

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
        """Moves for a while; answers with what Apex is to be told."""
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


def main():
    apex = subprocess.Popen([sys.argv[1], "run", sys.argv[2]], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    greeting = json.loads(apex.stdout.readline())
    print("agents:", *greeting["agents"], "- says:", *greeting["say"])
    balloon, now, answer = Balloon(), 0.0, {"wake": 0}
    while "end" not in answer:
        # Never farther than Apex wants to be stepped, and never farther than a step.
        wake = answer["wake"]
        to = now + STEP_S if wake is None or wake <= now else min(now + STEP_S, wake)
        inputs = balloon.move(to - now)
        if now < 100 <= to:
            inputs.append({"event": "(time to land)"})
        print(json.dumps({"advance": to, "inputs": inputs}), file=apex.stdin, flush=True)
        answer, now = json.loads(apex.stdout.readline()), to
        if "error" in answer:
            sys.exit(answer["error"])
        for effect in answer["effects"]:
            print(f"{now:g} s, {balloon.height_m:g} m: {json.dumps(effect)}")
            balloon.obey(effect)
    print("end:", answer["end"], "- says:", *answer.get("say", []))
    return apex.wait()


if __name__ == "__main__":
    sys.exit(main())
