"""Published fits to measured materials, from the package or from a folder.

A file of a folder is a JSON object of materials, each an object of parameters (`shrm.brdf.ABC.read`, ...).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path

from shrm import brdf
from shrm.brdf import ABC, BRDF, SGD, Lafortune

SOURCES: Mapping[str, tuple[str, str, Callable[[Path, str], BRDF]]] = {
    "MERL, fits of Löw et al. 2012": ("merl-abc", "merl_abc_low2012.json", ABC.read),
    "MERL, fits of Bagher et al. 2012": ("merl-sgd", "merl_sgd_bagher2012.json", SGD.read),
    "fits of Lafortune lobes": ("lafortune", "lafortune_pbrt1.json", Lafortune.read),
}
"""Sources by their titles: the name in `shrm.brdf.fits`, the file in a folder, and its reader."""


def read(folder: Path | None) -> dict[str, dict[str, BRDF]]:
    """Return the materials of each of `SOURCES` by name.

    Parameters
    ----------
    folder : Path, optional
        A folder of files, of which some may be missing. Without one, those that come with the package.

    Raises
    ------
    FileNotFoundError
        If the folder has none of the files.
    OSError, ValueError
        If a file cannot be read, or holds something else; the message names it.
    """
    if folder is None:
        return {
            title: {name: brdf.fits.fit(source, name) for name in brdf.fits.names(source)}
            for title, (source, _, _) in SOURCES.items()
        }
    materials = {
        title: {name: make(folder / file, name) for name in _names(folder / file)}
        for title, (_, file, make) in SOURCES.items()
        if (folder / file).exists()
    }
    if not materials:
        raise FileNotFoundError(f"{folder}: has none of {', '.join(file for _, file, _ in SOURCES.values())}")
    return materials


def _names(path: Path) -> list[str]:
    try:
        return list(dict(json.loads(path.read_text(encoding="utf-8"))))
    except (TypeError, ValueError) as fault:
        raise ValueError(f"{path}: not a file of fits ({fault})") from None
