#!/usr/bin/env python3
"""Simulate a pyramid of boxes, a pile of mixed convex shapes and a wall that a ball has hit for five seconds each at normal quality, draw their last
frames beside each other, and print how fast the fastest body still moves: python3 docs/gallery/at_rest.py WORK
(in the repository, with scree on the PATH; needs Pillow). WORK gets the models, the runs and the images; at_rest.jpg is in it."""
import csv, json, pathlib, random, subprocess, sys
from PIL import Image

WIDTH, HEIGHT, SECONDS = 640, 480, 5.0
# What is round would roll on for longer without rolling friction.
MATERIALS = {"stone": {"density": 2400, "friction": 0.6}, "pebble": {"density": 2400, "friction": 0.6, "rolling": 0.006},
             "steel": {"density": 7800, "friction": 0.3}}
GROUND = {"name": "ground", "material": "pebble", "plane": {"normal": [0, 0, 1]}}


def box(size, position, name="brick", **rest):
    return {"class": name, "material": "stone", "box": {"size": size}, "position": position, **rest}


def pyramid(rows=20, edge=0.3):
    place = lambda row, k: [(k - (rows - row - 1) / 2) * 1.05 * edge, 0, (row + 0.5) * edge]
    return [box([edge] * 3, place(row, k)) for row in range(rows) for k in range(rows - row)]


def pile(n=300):
    draw = random.Random(7)
    shapes = [{"box": {"size": [0.12, 0.1, 0.08]}}, {"cylinder": {"radius": 0.05, "length": 0.12}}, {"sphere": {"radius": 0.055}},
              {"capsule": {"radius": 0.035, "length": 0.08}}, {"cone": {"radius": 0.06, "length": 0.11}}]
    place = lambda k: [0.17 * (k % 5 - 2) + draw.uniform(-0.01, 0.01), 0.17 * (k // 5 % 5 - 2), 0.1 + 0.17 * (k // 25)]
    turn = lambda: {"axis": [draw.gauss(0, 1) for _ in range(3)], "angle": draw.uniform(0, 180)}
    chosen = [draw.choice(shapes) for _ in range(n)]
    return [{"class": list(chosen[k])[0], "material": "pebble", "position": place(k), "rotate": turn(), **chosen[k]} for k in range(n)]


def wall(rows=12, columns=10):
    size = [0.25, 0.12, 0.1]
    place = lambda row, k: [(k - columns / 2 + 0.25 + 0.5 * (row % 2)) * 0.252, 0, (row + 0.5) * size[2]]
    ball = {"class": "ball", "material": "steel", "sphere": {"radius": 0.15}, "position": [0.1, -3.0, 0.5], "velocity": [0, 6, 2]}
    return [box(size, place(row, k)) for row in range(rows) for k in range(columns)] + [ball]


work = pathlib.Path(sys.argv[1])
work.mkdir(parents=True, exist_ok=True)
sheet = Image.new("RGB", (3 * WIDTH, HEIGHT))
for column, (name, bodies) in enumerate([("pyramid", pyramid()), ("pile", pile()), ("wall", wall())]):
    bodies = [GROUND] + [{"name": f"b{k}", **body} for k, body in enumerate(bodies)]
    model = {"name": name, "quality": "normal", "duration": SECONDS, "frame_rate": 10, "materials": MATERIALS, "bodies": bodies}
    file, run, images = work / f"{name}.yaml", work / name, work / f"images_{name}"
    file.write_text(json.dumps(model))
    scree = lambda *words: subprocess.run(["scree", *map(str, words)], check=True, stdout=subprocess.DEVNULL)
    scree("simulate", file, "-o", run)
    last = int(SECONDS * 10) - 1
    scree("export", run, "--to", "csv", "-f", last, "-o", work / "tables")
    with open(work / "tables" / f"{name}_{last:06}.csv") as table:
        # The ball may still roll.
        speeds = [float(row["speed [m/s]"]) for row in csv.DictReader(table) if row["class"] not in ("ground", "ball")]
    print(f"{name}: fastest {max(speeds):.1e} m/s, mean {sum(speeds) / len(speeds):.1e} m/s")
    scree("render", run, "-f", last, "--res", f"{WIDTH}x{HEIGHT}", "--image-quality", "final", "-o", images)
    [image] = images.glob("*.png")
    sheet.paste(Image.open(image).convert("RGB"), (column * WIDTH, 0))
sheet.save(work / "at_rest.jpg", quality=88)
