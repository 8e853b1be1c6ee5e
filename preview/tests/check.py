"""Checks of scree-preview: recordings are read back by the Python package of Rerun, and a served one is looked at in a browser.

usage: check.py SCREE SCREE_PREVIEW [PICTURE.png]
"""

import pathlib
import re
import subprocess
import sys
import tempfile
import time

import numpy as np
import pyarrow.feather as feather
from PIL import Image
from playwright.sync_api import sync_playwright
from rerun.experimental import RrdReader

MODEL = """\
step: 0.002
duration: 0.4
frame_rate: 30
materials: {stone: {density: 2600, friction: 0.5}}
bodies:
  - {name: ground, material: stone, plane: {normal: [0, 0, 1]}}
  - {name: block, material: stone, box: {size: [0.4, 0.4, 0.2]}, position: [0.5, 0, 0.3]}
fills:
  - {name: stones, material: stone, count: 60, radius: [0.04, 0.05], min: [-0.3, -0.3, 0.1], max: [0.3, 0.3, 0.9]}
"""


def call(*args):
    return subprocess.run([str(a) for a in args], check=True, capture_output=True, text=True)


def chunks(path):
    """The chunks of each entity of a recording."""
    found = {}
    for chunk in RrdReader(str(path)).stream():
        found.setdefault(chunk.entity_path, []).append(chunk.to_record_batch())
    return found


def column(batches, name):
    """The values of a column with its times, s, row by row."""
    rows = []
    for batch in batches:
        names = batch.schema.names
        if name in names and "time" in names:
            times = np.asarray(batch.column("time")).astype("timedelta64[ns]").astype(float) * 1e-9
            rows += zip(times, batch.column(name).to_pylist())
    return sorted(rows, key=lambda row: row[0])


def saved(scree, preview, folder):
    """A saved recording has the positions of the run, frame by frame, and its probes."""
    run = folder / "run"
    call(scree, "simulate", folder / "m.yaml", "-o", run)
    call(preview, run, "-o", folder / "a.rrd")
    found = chunks(folder / "a.rrd")
    names = [name for name in found if name.startswith("/bodies/")]
    assert len(names) == 3, names
    spheres = next(name for name in names if any("Points3D:positions" in b.schema.names for b in found[name]))
    frames = sorted((run / "frames").glob("*.arrow"))
    rows = column(found[spheres], "Points3D:positions")
    assert len(rows) == len(frames) == 12, (len(rows), len(frames))
    for (_, positions), frame in zip(rows, frames):
        table = feather.read_table(frame).to_pandas()
        own = table[table["shape"].astype(str) == "sphere"]
        np.testing.assert_allclose(positions, own[["pos_x", "pos_y", "pos_z"]].to_numpy(), atol=1e-6)
    probes = column(found["/probes/energy.kinetic"], "Scalars:scalars")
    lines = (run / "probes.csv").read_text().splitlines()
    head = [re.sub(r" \[.*", "", cell) for cell in lines[0].split(",")]
    expected = [float(line.split(",")[head.index("energy.kinetic")]) for line in lines[1:]]
    np.testing.assert_allclose([value[0] for _, value in probes], expected)
    # What is no recording is not replaced, and a wrong name is refused.
    (folder / "b.rrd").write_text("mine")
    for goal in ["b.rrd", "b.txt"]:
        answer = subprocess.run([preview, run, "-o", folder / goal], capture_output=True)
        assert answer.returncode == 2, answer.stderr
    assert (folder / "b.rrd").read_text() == "mine"
    return run


def followed(scree, preview, folder):
    """A run that is followed while it is written is whole in the end."""
    run = folder / "live"
    goal = folder / "live.rrd"
    watcher = subprocess.Popen([preview, run, "--wait", "-o", goal], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    time.sleep(0.5)
    call(scree, "simulate", folder / "m.yaml", "-o", run)
    assert watcher.wait(60) == 0, watcher.stderr.read()
    rows = column(chunks(goal)["/bodies/block"], "Boxes3D:centers")
    assert len(rows) == 12, len(rows)


def large(preview, folder):
    """A hundred thousand spheres: frames a second, and bytes of a sphere and frame."""
    n, frames = 100_000, 10
    grid = np.stack(np.meshgrid(*[np.arange(50.0)] * 3), -1).reshape(-1, 3)[:n]
    for k in range(frames):
        grid = np.column_stack([grid[:, :3] + 0.01, np.full(len(grid), 0.5)])
        table = np.column_stack([grid, np.linspace(0, 1 + k, len(grid))])
        np.savetxt(folder / f"p_{k}.csv", table, "%.4f", ",", header="x,y,z,radius,speed", comments="")
    call(preview, folder / "p_*.csv", "-o", folder / "large.rrd")
    size = (folder / "large.rrd").stat().st_size / n / frames
    print(f"{n} spheres from CSV: {size:.1f} bytes a sphere and frame")
    assert size <= 20, size
    answer = call(preview, folder / "p_*.csv", "-o", folder / "thin.rrd", "--most", "1000")
    assert "each 100th is shown" in answer.stderr, answer.stderr


def seen(preview, run, picture):
    """The page shows the bodies: the block's colour is in the middle of the picture, and plots stand beside it."""
    server = subprocess.Popen([preview, run, "--web", "--no-follow"], stdout=subprocess.PIPE, text=True)
    try:
        url = server.stdout.readline().strip()
        assert url.startswith("http://localhost:9090/"), url
        with sync_playwright() as p:
            browser = p.chromium.launch(
                executable_path="/usr/bin/chromium",
                args=["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
                      "--disable-component-update", "--disable-sync", "--use-angle=swiftshader",
                      "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
            )
            page = browser.new_page(viewport={"width": 1280, "height": 720})
            page.goto(url)
            for _ in range(80):
                page.wait_for_timeout(3000)
                page.screenshot(path=picture)
                if is_whole(picture):
                    break
            else:
                raise AssertionError("bodies and curves are not seen")
            browser.close()
    finally:
        server.terminate()


def is_whole(picture):
    """Whether a picture of the page has bodies on the left, and curves on the right."""
    shot = np.asarray(Image.open(picture).convert("RGB")).astype(int)
    bodies, plots = shot[60:560, 10:840], shot[60:560, 870:1270]
    is_dark = (bodies.max(-1) < 150).sum()
    is_curve = (plots.max(-1) - plots.min(-1) > 60).sum()
    return is_dark > 5000 and is_curve > 200


def main():
    scree, preview = (pathlib.Path(arg).resolve() for arg in sys.argv[1:3])
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "m.yaml").write_text(MODEL)
        run = saved(scree, preview, folder)
        followed(scree, preview, folder)
        large(preview, folder)
        picture = pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else folder / "page.png"
        seen(preview, run, picture)
    print("the preview is as it should be")


main()
