#!/usr/bin/env python3
"""Measure a film's images (PNG, 8 bits): python3 measure.py FOLDER ... (needs numpy and Pillow).

flicker  mean change of still regions from image to image, of 255: of blocks of 16 x 16 pixels, those that change least, a half of all
speckle  share of pixels that differ by more than 24 from the median of their 3 x 3, and by more than 24 from each of their neighbours
bands    share of the smooth pixels (a range of at most 3 of 255 in 9 x 9) that have exactly the value of all their 8 neighbours
dark, bright  share of the pixels at 12 or below, and at 240 or above (luminance), in the image that has the fewest
"""
import sys, pathlib, numpy as np
from PIL import Image


def luminance(path):
    return np.asarray(Image.open(path).convert("RGB"), dtype=np.float32) @ np.float32([0.2126, 0.7152, 0.0722])


def around(a, r):
    """The pixels shifted by up to r both ways, without the margin."""
    n, m = a.shape
    return np.stack([a[y : n - 2 * r + y, x : m - 2 * r + x] for y in range(2 * r + 1) for x in range(2 * r + 1)])


def measure(folder):
    paths = sorted(pathlib.Path(folder).glob("[0-9]*.png"))
    speckle, bands, dark, bright, flicker, before = [], [], [], [], [], None
    for path in paths:
        a = luminance(path)
        near = around(a, 1)
        middle, others = near[4], np.delete(near, 4, 0)
        alone = (np.abs(middle - np.median(near, 0)) > 24) & (np.abs(others - middle).min(0) > 24)
        speckle.append(alone.mean())
        wide = around(a, 4)
        smooth = wide.max(0) - wide.min(0) <= 3
        same = (np.abs(others - middle).max(0) == 0)[3:-3, 3:-3]
        bands.append((same & smooth).sum() / max(1, smooth.sum()))
        dark.append((a <= 12).mean())
        bright.append((a >= 240).mean())
        if before is not None:
            n, m = a.shape[0] // 16 * 16, a.shape[1] // 16 * 16
            change = np.abs(a - before)[:n, :m].reshape(n // 16, 16, m // 16, 16).mean((1, 3)).ravel()
            flicker.append(np.sort(change)[: len(change) // 2].mean())
        before = a
    worst = max(flicker, default=0.0)
    print(f"{folder}: {len(paths)} images, flicker {worst:.3f}, speckle {100 * max(speckle):.4f} %, bands {100 * max(bands):.1f} %, "
          f"dark {100 * min(dark):.3f} %, bright {100 * min(bright):.3f} %")


for folder in sys.argv[1:]:
    measure(folder)
