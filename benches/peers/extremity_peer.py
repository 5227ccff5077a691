"""Shortest ways around polygons by extremitypathfinder, as worlds that Apex's tests read.

    extremity_peer.py worlds             print the worlds of crates/geo/src/travel/golden/extremity.txt
    extremity_peer.py check FILE         compute the lengths of FILE again and compare
    extremity_peer.py matrix FILE        the travel matrix of FILE, for `make bench-travel`: seconds and lengths as JSON

A world is lines of words: `world NAME`, `boundary x y ..`, one `hole x y ..` for each obstacle, `place x y` lines, and
`way from to length` with the numbers of places; `none` where no way leads. Holes do not overlap, as the peer demands.
"""

import json
import math
import random
import sys
import time

from extremitypathfinder import PolygonEnvironment

WORLDS = 60
PLACES = 6
AGREE = 1e-9


def star(rng, x, y, radius, corners):
    """Return a polygon around (x, y), counter-clockwise, in general not convex."""
    angles = sorted((i + 0.4 * rng.random()) * 2 * math.pi / corners for i in range(corners))
    lengths = [radius * (0.25 + 0.75 * rng.random()) for _ in angles]
    return [(x + r * math.cos(a), y + r * math.sin(a)) for a, r in zip(angles, lengths)]


def inside(point, polygon):
    """Return whether a point is inside, by counting crossings; no point of a random world is on an edge."""
    (px, py), odd = point, False
    for (ax, ay), (bx, by) in zip(polygon, polygon[1:] + polygon[:1]):
        if (ay > py) != (by > py) and px < ax + (bx - ax) * (py - ay) / (by - ay):
            odd = not odd
    return odd


def make(seed):
    """Return a world of up to 16 obstacles in cells of a grid, inside a ragged boundary."""
    rng = random.Random(seed)
    grid = rng.randint(1, 4)
    holes = [
        star(rng, 20 * i + 10, 20 * j + 10, 9.9, rng.randint(3, 9))
        for i in range(grid)
        for j in range(grid)
        if rng.random() < 0.9
    ]
    middle, size = 10 * grid, 10 * grid * math.sqrt(2) + 4
    corners = rng.randint(8, 20)
    angles = [(i + 0.5 * rng.random()) * 2 * math.pi / corners for i in range(corners)]
    # The boundary is ragged, but stays outside the grid of obstacles.
    boundary = []
    for angle in angles:
        radius = size * (1.15 + 0.6 * rng.random())
        boundary.append((middle + radius * math.cos(angle), middle + radius * math.sin(angle)))
    places = []
    while len(places) < PLACES:
        point = (middle + 2 * size * (rng.random() - 0.5), middle + 2 * size * (rng.random() - 0.5))
        if inside(point, boundary) and not any(inside(point, hole) for hole in holes):
            places.append(point)
    return boundary, holes, places


def environment(boundary, holes):
    """Return the peer's environment. The peer needs clockwise obstacles; its validation refuses some simple polygons."""
    env = PolygonEnvironment()
    env.store(boundary, [hole[::-1] for hole in holes], validate=False)
    env.prepare()
    return env


def ways(env, places):
    """Yield both numbers and the length for each pair of places, the lower number first."""
    for i, start in enumerate(places):
        for j, goal in enumerate(places[i + 1 :], i + 1):
            yield i, j, env.find_shortest_path(start, goal)[1]


def words(points):
    return " ".join(f"{x!r} {y!r}" for x, y in points)


def worlds():
    for seed in range(WORLDS):
        boundary, holes, places = make(seed)
        print(f"world {seed}")
        print(f"boundary {words(boundary)}")
        for hole in holes:
            print(f"hole {words(hole)}")
        for place in places:
            print(f"place {words([place])}")
        for i, j, length in ways(environment(boundary, holes), places):
            print(f"way {i} {j} {'none' if length is None else repr(float(length))}")


def read(path):
    """Return the worlds of a file: name, boundary, holes, places, ways."""
    found = []
    for line in open(path, encoding="utf-8"):
        kind, *rest = line.split()
        if kind == "world":
            found.append({"name": rest[0], "holes": [], "places": [], "ways": []})
            continue
        if kind == "way":
            found[-1]["ways"].append((int(rest[0]), int(rest[1]), rest[2]))
            continue
        numbers = [float(word) for word in rest]
        points = list(zip(numbers[::2], numbers[1::2]))
        if kind == "boundary":
            found[-1]["boundary"] = points
        elif kind == "hole":
            found[-1]["holes"].append(points)
        elif kind == "place":
            found[-1]["places"] += points
        else:
            sys.exit(f"{path}: unknown line `{kind}`")
    return found


def check(path):
    count = 0
    for world in read(path):
        env = environment(world["boundary"], world["holes"])
        for i, j, told in world["ways"]:
            length = env.find_shortest_path(world["places"][i], world["places"][j])[1]
            agrees = length is None if told == "none" else abs(length - float(told)) <= AGREE * (1 + length)
            if not agrees:
                sys.exit(f"{path}: world {world['name']}, way {i} {j}: the file says {told}, the peer {length}")
            count += 1
    print(f"{count} ways agree")


def matrix(path):
    (world,) = read(path)
    begun = time.process_time()
    env = environment(world["boundary"], world["holes"])
    prepared = time.process_time()
    lengths = [(i, j, None if length is None else float(length)) for i, j, length in ways(env, world["places"])]
    json.dump(
        {"prepare_s": prepared - begun, "ways_s": time.process_time() - prepared, "ways": lengths},
        sys.stdout,
    )


if __name__ == "__main__":
    command = {"worlds": worlds, "check": check, "matrix": matrix}.get(sys.argv[1] if len(sys.argv) > 1 else "")
    if command is None:
        sys.exit(__doc__)
    command(*sys.argv[2:])
