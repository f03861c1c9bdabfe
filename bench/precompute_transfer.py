"""Precomputing an object with transfer, alone in a process: the time of each stage, and the most memory.

    python bench/precompute_transfer.py MESH BRDF VARIANT,...        # as JSON

A mesh is brought to 50,000 vertices by taking the midpoints of its longest edges as vertices.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np
from shrm import brdf
from shrm.render import Mesh
from shrm.transfer import precompute

V, DIRECTIONS = 50_000, 4096


def refined(mesh: Mesh) -> Mesh:
    """Split edges, the longest first, none of whose faces has been split, until there are V vertices."""
    edges = np.sort(mesh.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    distinct, which = np.unique(edges, axis=0, return_inverse=True)
    lengths = np.linalg.norm(np.subtract(*mesh.vertices[distinct.T]), axis=1)
    faces_of: list[list[int]] = [[] for _ in distinct]
    for face, edge in enumerate(which.reshape(-1, 3)):
        for e in edge:
            faces_of[e].append(face)
    split = np.zeros(len(mesh.faces), bool)
    places, added, kept = list(mesh.vertices), [], len(mesh.vertices)
    for e in np.argsort(-lengths):
        if len(places) == V:
            break
        if split[faces_of[e]].any():
            continue
        a, b = distinct[e]
        places.append((mesh.vertices[a] + mesh.vertices[b]) / 2)
        for face in faces_of[e]:
            split[face] = True
            corners = mesh.faces[face]
            for old in (a, b):
                added.append(np.where(corners == old, kept, corners))
        kept += 1
    return Mesh(np.array(places), np.concatenate([mesh.faces[~split], np.array(added, np.int64)]))


def most_memory() -> int:
    """Return the most bytes that this process had in memory; getrusage counts those of its parent, too."""
    said = Path("/proc/self/status").read_text()
    return 1024 * int(next(line for line in said.splitlines() if line.startswith("VmHWM")).split()[1])


def main(mesh: str, material: str, variants: str) -> None:
    """Compute, print."""
    placed = refined(Mesh.read(mesh).placed(radius=1.0))
    stages: dict[str, float] = {}
    begun = [time.perf_counter(), ""]

    def progress(stage: str, done: int, total: int) -> None:
        now = time.perf_counter()
        if stage != begun[1]:
            stages[begun[1]] = stages.get(begun[1], 0.0) + now - begun[0]
            begun[:] = [now, stage]

    start = time.perf_counter()
    begun[0] = start
    made = precompute(
        placed,
        brdf.parse(material),
        directions=DIRECTIONS,
        variants=variants.split(","),
        progress=progress,
    )
    progress("", 0, 0)
    print(
        json.dumps(
            {
                "vertices": len(placed.vertices),
                "material": made.material,
                "variants": list(made.variants),
                "M": made.M,
                "SNR": made.report["SNR of matrices"],
                "K": [variant.K for variant in made.variants.values()],
                "seconds": time.perf_counter() - start,
                "stages": {name: seconds for name, seconds in stages.items() if name},
                "bytes": most_memory(),
            }
        )
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
