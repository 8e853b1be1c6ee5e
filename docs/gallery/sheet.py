#!/usr/bin/env python3
"""Draw every scene of the library with gravel, a vehicle, a machine and a table: python3 docs/gallery/sheet.py WORK
(in the repository, with scree on the PATH; needs Pillow). WORK gets the runs, the metadata and the images; sheet.jpg is in it."""
import pathlib, re, subprocess, sys
from PIL import Image

SCENES = "studio seamless quarry desert_noon desert_dusk lunar laboratory test_bench turntable cutaway white_page dark_page".split()
# Name, model or table, frame.
DATA = [("gravel", "sim/models/quickstart.yaml", 30), ("vehicle", "docs/gallery/rover.yaml", 30),
        ("machine", "docs/gallery/linkage.yaml", 20), ("table", "docs/gallery/grains_*.csv", 0)]
WIDTH, HEIGHT = 640, 360


def scree(*words):
    subprocess.run(["scree", *map(str, words)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


work = pathlib.Path(sys.argv[1])
work.mkdir(parents=True, exist_ok=True)
sheet = Image.new("RGB", (WIDTH * len(DATA), HEIGHT * len(SCENES)))
for column, (name, source, frame) in enumerate(DATA):
    data = source
    if source.endswith(".yaml"):
        data = work / name
        if not data.exists():
            scree("simulate", source, "-o", data)
    first = work / f"{name}.yaml"
    first.unlink(missing_ok=True)
    scree("inspect", data, "--write", first)
    for row, scene in enumerate(SCENES):
        file, images = work / f"{name}_{scene}.yaml", work / f"images_{name}_{scene}"
        file.write_text(re.sub(r"^scene: .*$", f"scene: {scene}.rib", first.read_text(), flags=re.M))
        scree("render", file, "-f", frame, "--res", f"{WIDTH}x{HEIGHT}", "-o", images)
        sheet.paste(Image.open(images / f"{frame:06}.png").convert("RGB"), (column * WIDTH, row * HEIGHT))
sheet.save(work / "sheet.jpg", quality=86)
