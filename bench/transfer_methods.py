"""All ways to light an object with transfer, in a process whose threads stay on processors of their own.

python bench/transfer_methods.py MESH`; prints the rows of [LK03] table 1 as JSON.
"""

import json
import sys
from dataclasses import asdict
from pathlib import Path

from shrm.render import Mesh
from shrm_papers.lk03.methods import compare
from shrm_papers.lk03.subject import DIRECTIONS, Subject
from shrm_papers.lk03.table_1 import PAPER


def main(mesh: str) -> None:
    """Compare, print."""
    subject = Subject(Mesh.read(mesh).placed(radius=1.0), Path(mesh).stem, DIRECTIONS)
    rows = [
        {**asdict(one), "paper": theirs and theirs[not one.shadowed]}
        for one in compare(subject)
        for theirs in [PAPER.get(one.method)]
    ]
    print(json.dumps(rows))


if __name__ == "__main__":
    main(*sys.argv[1:])
