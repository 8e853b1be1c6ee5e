"""Checks that run directories and exports open in other programs' readers, with the same values.

usage: exports.py SCREE
"""

import pathlib
import subprocess
import sys
import tempfile

import ase.io
import meshio
import numpy as np
import pandas as pd
import pyarrow.parquet as pq

MODEL = """\
name: m
step: 0.002
duration: 0.2
frame_rate: 30
materials: {stone: {density: 2600, friction: 0.5}}
bodies:
  - {name: ground, material: stone, plane: {normal: [0, 0, 1]}}
  - {name: block, material: stone, box: {size: [0.4, 0.4, 0.2]}, position: [0.5, 0, 0.3]}
fills:
  - {name: stones, material: stone, count: 20, radius: [0.04, 0.05], min: [-0.3, -0.3, 0.1], max: [0.3, 0.3, 0.9]}
probes: {bodies: [block]}
"""


def call(*args):
    return subprocess.run([str(a) for a in args], check=True, capture_output=True, text=True)


def main(scree):
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        run = folder / "run"
        (folder / "m.yaml").write_text(MODEL)
        call(scree, "simulate", folder / "m.yaml", "-o", run)

        # A run directory, in two lines.
        frame = pd.read_feather(run / "frames/000003.arrow")
        probes = pd.read_csv(run / "probes.csv")
        assert len(frame) == 22 and set(frame["class"]) == {"ground", "block", "stones"}, frame
        assert probes["time [s]"].iloc[-1] > 0.15 and len(probes.columns) > 6, probes

        for kind in ("vtu", "parquet", "xyz", "ply", "csv"):
            call(scree, "export", run, "--to", kind, "-o", folder / kind)
        place = frame[["pos_x", "pos_y", "pos_z"]].to_numpy()
        mesh = meshio.read(folder / "vtu/run_000003.vtu")
        np.testing.assert_array_equal(mesh.points, place)
        np.testing.assert_array_equal(mesh.point_data["vel"], frame[["vel_x", "vel_y", "vel_z"]].to_numpy())
        np.testing.assert_array_equal(mesh.point_data["id"], frame["id"].to_numpy())
        times = [line.split('timestep="')[1].split('"')[0] for line in (folder / "vtu/run.pvd").read_text().splitlines() if "timestep" in line]
        assert len(times) == 6 and abs(float(times[3]) - 0.1) < 0.003, times
        table = pq.read_table(folder / "parquet/run_000003.parquet")
        assert table.schema.field("pos_x").metadata[b"unit"] == b"m", table.schema
        pd.testing.assert_frame_equal(table.to_pandas()[["id", "pos_x", "speed"]], frame[["id", "pos_x", "speed"]])
        np.testing.assert_array_equal(mesh.point_data["quat"][:, 3], frame["quat_w"].to_numpy())
        grains = ase.io.read(folder / "xyz/run_000003.xyz", format="extxyz")
        np.testing.assert_array_equal(grains.positions, place)
        np.testing.assert_allclose(grains.arrays["velo"][:, 2], frame["vel_z"].to_numpy(), atol=1e-7)
        cloud = meshio.read(folder / "ply/run_000003.ply")
        np.testing.assert_allclose(cloud.points, place, atol=1e-6)
        text = pd.read_csv(folder / "csv/run_000003.csv")
        np.testing.assert_array_equal(text["pos_z [m]"].to_numpy(), place[:, 2])
    print("exports and run directories open in pandas, pyarrow, ASE and meshio")


main(*sys.argv[1:])
