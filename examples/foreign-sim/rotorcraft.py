"""A rotorcraft that flies missions of surveillance: it obeys the commands of `library/vehicle.pdl` that such missions use.

It knows the places of the mission, moves in a straight line through still air, and tells where it is.
"""

import json
import math
import re
from pathlib import Path

CRUISE_MPS = 10.0
CLIMB_MPS = 2.5
METRES_PER_DEGREE = 111_195.0
UNITS_S = {"H": 3600.0, "M": 60.0, "S": 1.0}


def read_form(text):
    """A form of PDL as nested lists of words."""
    stack = [[]]
    for word in re.findall(r"[()]|[^\s()]+", text):
        if word == "(":
            stack.append([])
        elif word == ")":
            done = stack.pop()
            stack[-1].append(done)
        else:
            stack[-1].append(word)
    return stack[0][0]


def number(word):
    """The number before a unit: `110m`, `-121.1`."""
    return float(re.match(r"-?[\d.]+", word).group())


def seconds(word):
    """A duration: `40s`, `2min`, `1h`, `P1M30S`."""
    if word.startswith("P"):
        return sum(float(count) * UNITS_S[unit] for count, unit in re.findall(r"([\d.]+)([HMS])", word))
    return number(word) * {"s": 1.0, "min": 60.0, "h": 3600.0}[re.sub(r"^[\d.]+", "", word)]


def places_of(mission):
    """Names with (latitude, longitude, altitude of the ground) from the mission's GeoJSON."""
    places = {}
    for feature in json.loads((Path(mission) / "sites.geojson").read_text())["features"]:
        longitude, latitude = feature["geometry"]["coordinates"][:2]
        properties = feature["properties"]
        places[properties["id"]] = (latitude, longitude, float(properties.get("elevation_m", 0)))
    return places


# The camera has no model: what it is commanded is done at once, and it measures nothing.
CAMERA_COMMANDS = ("camera", "point-camera", "take-picture", "take-pictures", "stop-pictures")


class Rotorcraft:
    """Where it is, and the command that it carries out."""

    def __init__(self, name, places):
        self.name = name
        self.places = places
        self.here = places["home"]
        self.command = None
        self.legs = []
        self.rest_s = 0.0
        self.answers = []

    def obey(self, effect):
        """Takes one effect of Apex."""
        if "command" in effect and read_form(effect["form"])[0] in CAMERA_COMMANDS:
            self.answers.append({"acknowledge": effect["command"]})
        elif "command" in effect:
            legs, rest_s = self.legs_of(*read_form(effect["form"]))
            if legs is None:
                self.answers.append({"acknowledge": effect["command"], "error": "this rotorcraft cannot do that"})
            else:
                self.command, self.legs, self.rest_s = effect["command"], legs, rest_s
        elif "withdraw" in effect and effect["withdraw"] == self.command:
            self.command = None

    def legs_of(self, verb, *words):
        """Way points of a command, and the time to stay at the last one; no way points for an unknown command."""
        options = dict(zip(words[1::2], words[2::2], strict=False)) if words else {}
        if verb == "take-off":
            return [(*self.here[:2], self.here[2] + number(words[0]))], 0.0
        if verb in ("fly-to", "hover", "loiter", "land"):
            latitude, longitude, altitude = self.place(words[0])
            if ":altitude" in options:
                altitude = number(options[":altitude"])
            high = max(altitude, self.here[2]) if verb == "land" else altitude
            legs = [(latitude, longitude, high)] + ([(latitude, longitude, altitude)] if verb == "land" else [])
            stays = verb in ("hover", "loiter")
            return legs, seconds(options[":duration"]) if ":duration" in options else math.inf if stays else 0.0
        return None, 0.0

    def place(self, words):
        """A location, or a place's name."""
        if isinstance(words, str):
            return self.places[words]
        latitude, longitude, *altitude = map(number, words)
        return latitude, longitude, altitude[0] if altitude else self.here[2]

    def move(self, for_s):
        """Moves for a while; returns the inputs for Apex."""
        while self.command is not None and self.legs and for_s > 0:
            for_s -= self.fly(self.legs[0], for_s)
            if self.here == self.legs[0]:
                self.legs.pop(0)
        inputs, self.answers = self.answers, []
        if self.command is not None and not self.legs:
            self.rest_s -= for_s
            if self.rest_s <= 0:
                inputs.append({"acknowledge": self.command})
                self.command = None
        return inputs + [
            {"measurement": f"(location {self.name})", "value": {"pdl": "({:.6f} {:.6f} {:.1f})".format(*self.here)}},
            {"measurement": "(signal-level 900MHzModem)", "value": 1.0},
        ]

    def said_at(self, _now, _to):
        """Events from outside between two instants: none."""
        return []

    def state(self):
        """Where it is, as text."""
        return "({:.4f} {:.4f} {:.0f})".format(*self.here)

    def fly(self, goal, for_s):
        """Flies towards a way point; answers with the seconds that it took."""
        north = (goal[0] - self.here[0]) * METRES_PER_DEGREE
        east = (goal[1] - self.here[1]) * METRES_PER_DEGREE * math.cos(math.radians(goal[0]))
        needed_s = max(math.hypot(north, east) / CRUISE_MPS, abs(goal[2] - self.here[2]) / CLIMB_MPS)
        if needed_s <= for_s:
            self.here = goal
            return needed_s
        share = for_s / needed_s
        self.here = tuple(here + share * (there - here) for here, there in zip(self.here, goal, strict=True))
        return for_s
