"""Shared by the tests of pictures: a pulse, results to draw, and what a picture shows."""

import json

import numpy as np
from PIL import Image


def bump(distance, width=10.0):
    return np.exp(-((distance / width) ** 2))


def finish(folder, probes=None, **metrics):
    """What only a run that ended well leaves."""
    (folder / "case.toml").write_text('title = "A case that costs $5 or $6"\n[probes]\na = [10.0]\n')
    probes = {name: {"position": place, "activation_time": 0.5} for name, place in (probes or {}).items()}
    (folder / "results.json").write_text(
        json.dumps({"completed": True, "metrics": metrics, "probes": probes})
    )
    if probes:
        times = np.linspace(0, 1, 50)
        table = np.column_stack([times, *(bump(times - 0.1 * i, 0.1) for i in range(2 * len(probes)))])
        header = ",".join(f"{name}_{field}" for name in probes for field in ("potential", "displacement_x"))
        np.savetxt(folder / "probes.csv", table, delimiter=",", header=f"time,{header}", comments="")


def names(paths):
    return [path.name for path in paths]


def pixels(path):
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def share(image, colour, tolerance=40):
    """Share of an image's pixels near a colour."""
    return np.mean(np.abs(image - np.array(colour)).max(axis=-1) < tolerance)


def check_pictures(paths):
    for path in paths:
        image = pixels(path)
        assert path.parent.name == "figures"
        assert min(image.shape[:2]) > 200
        assert len(np.unique(image @ [1, 256, 65536])) > 20
        assert tuple(image[0, 0]) == (255, 255, 255)
