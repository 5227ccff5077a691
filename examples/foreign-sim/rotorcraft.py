"""A rotorcraft that flies missions of surveillance: it obeys the commands of `library/vehicle.pdl` that such missions use.

It knows the places of the mission, moves in a straight line through still air, and tells where it is. Its camera takes pictures.
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


CAMERA_COMMANDS = ("camera", "point-camera", "take-picture", "take-pictures", "stop-pictures")


def offset_m(here, there):
    """The way from one point to another: metres to the north, to the east and up."""
    north = (there[0] - here[0]) * METRES_PER_DEGREE
    east = (there[1] - here[1]) * METRES_PER_DEGREE * math.cos(math.radians(here[0]))
    return north, east, there[2] - here[2]


class Camera:
    """A camera that tilts, on a vehicle that turns towards its target; it obeys at once.

    Before each picture come the position, the attitude and the angles of the mount that belong to it: Apex computes the seen ground from
    them.
    """

    def __init__(self, name):
        self.name = name
        self.target = "down"
        self.tilt_deg = 0.0
        self.every_m = None
        self.flown_m = 0.0

    def obey(self, vehicle, verb, words):
        """Carries out a command; returns the inputs for Apex."""
        if verb == "camera" and words[0] == "power-up":
            return [measured("camera-state", self.name, "ready"), {"event": f"(ready {self.name})"}]
        if verb == "camera":
            self.every_m = None
            return [measured("camera-state", self.name, "off" if words[0] == "power-off" else "resting")]
        if verb == "point-camera":
            self.point(vehicle, words[0])
            return self.angles()
        options = dict(zip(words[::2], words[1::2], strict=False))
        if verb == "take-picture":
            return [line for _ in range(int(options.get(":count", 1))) for line in self.picture(vehicle)]
        self.every_m = number(options[":every"]) if verb == "take-pictures" else None
        self.flown_m = 0.0
        return self.picture(vehicle) if self.every_m else []

    def point(self, vehicle, words):
        """Turns the vehicle and tilts the camera towards a place; a place without an altitude is on the ground."""
        self.target = words if isinstance(words, str) else "down"
        self.tilt_deg = -90.0
        if words != "down":
            place = vehicle.places[words] if isinstance(words, str) else vehicle.ground(words)
            north, east, up = offset_m(vehicle.here, place)
            self.tilt_deg = math.degrees(math.atan2(up, math.hypot(north, east)))
            vehicle.heading_deg = math.degrees(math.atan2(east, north)) % 360

    def angles(self):
        """The angles of the mount, as measurements."""
        tilt = measured("camera-tilt", self.name, f"{self.tilt_deg:.3f}deg")
        return [tilt, measured("camera-pan", self.name, "0deg")]

    def picture(self, vehicle):
        """Takes a picture."""
        events = [f"(image-taken {self.name} {self.target})", f"(image-in-memory {self.target})"]
        return vehicle.reports() + self.angles() + [{"event": event} for event in events]

    def fly(self, vehicle, flown_m):
        """Takes the pictures that a way over ground asks for, at most one for each call."""
        self.flown_m += flown_m
        if self.every_m is None or self.flown_m < self.every_m:
            return []
        self.flown_m %= self.every_m
        return self.picture(vehicle)


def measured(attribute, item, value):
    """A measurement as an input for Apex."""
    return {"measurement": f"({attribute} {item})", "value": {"pdl": value}}


class Rotorcraft:
    """Where it is, and the command that it carries out."""

    def __init__(self, name, places):
        self.name = name
        self.places = places
        self.here = places["home"]
        self.heading_deg = 0.0
        self.cameras = {}
        self.command = None
        self.legs = []
        self.rest_s = 0.0
        self.answers = []

    def obey(self, effect):
        """Takes one effect of Apex."""
        verb, *words = read_form(effect["form"]) if "command" in effect else [None]
        if verb in CAMERA_COMMANDS:
            camera = self.cameras.setdefault(words[0], Camera(words[0]))
            self.answers += camera.obey(self, verb, words[1:])
            self.answers.append({"acknowledge": effect["command"]})
        elif "command" in effect:
            legs, rest_s = self.legs_of(verb, *words)
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

    def ground(self, words):
        """A location; without an altitude it is as high as the start."""
        latitude, longitude, *altitude = map(number, words)
        return latitude, longitude, altitude[0] if altitude else self.places["home"][2]

    def place(self, words):
        """A location, or a place's name."""
        if isinstance(words, str):
            return self.places[words]
        latitude, longitude, *altitude = map(number, words)
        return latitude, longitude, altitude[0] if altitude else self.here[2]

    def move(self, for_s):
        """Moves for a while; returns the inputs for Apex."""
        inputs, self.answers = self.answers, []
        while self.command is not None and self.legs and for_s > 0:
            before = self.here
            for_s -= self.fly(self.legs[0], for_s)
            flown_m = math.hypot(*offset_m(before, self.here)[:2])
            inputs += [line for camera in self.cameras.values() for line in camera.fly(self, flown_m)]
            if self.here == self.legs[0]:
                self.legs.pop(0)
        if self.command is not None and not self.legs:
            self.rest_s -= for_s
            if self.rest_s <= 0:
                inputs.append({"acknowledge": self.command})
                self.command = None
        return inputs + self.reports() + [{"measurement": "(signal-level 900MHzModem)", "value": 1.0}]

    def reports(self):
        """Position and attitude, as measurements: it flies level, and turns without banking."""
        return [
            measured("location", self.name, "({:.6f} {:.6f} {:.1f})".format(*self.here)),
            measured("altitude", self.name, f"{self.here[2]:.1f}m"),
            measured("heading", self.name, f"{self.heading_deg:.3f}deg"),
            measured("roll-angle", self.name, "0deg"),
            measured("pitch-angle", self.name, "0deg"),
        ]

    def said_at(self, _now, _to):
        """Events from outside between two instants: none."""
        return []

    def state(self):
        """Where it is, as text."""
        return "({:.4f} {:.4f} {:.0f})".format(*self.here)

    def fly(self, goal, for_s):
        """Flies towards a way point; answers with the seconds that it took."""
        north, east, up = offset_m(self.here, goal)
        needed_s = max(math.hypot(north, east) / CRUISE_MPS, abs(up) / CLIMB_MPS)
        if math.hypot(north, east) > 1:
            self.heading_deg = math.degrees(math.atan2(east, north)) % 360
        if needed_s <= for_s:
            self.here = goal
            return needed_s
        share = for_s / needed_s
        self.here = tuple(here + share * (there - here) for here, there in zip(self.here, goal, strict=True))
        return for_s
