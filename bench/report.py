"""Writes the measured tables of README.md and bench/README.md from what `./run bench` left.

    python bench/report.py build/bench.json

A table stands between two markers, and the first says which it is:

    <!-- bench: analysis, synthesis -->  ...  <!-- /bench -->

Names are groups of the benchmarks, whose rows say time, error and share of the machine's limit, or one of
`machine` (its limits), `kernels`, `beside the prototype`, `Fourier`, `methods`, `crossover`,
`transfer methods`, `transfer precomputation`, `lighting` and `measured`.
"""

import json
import re
import sys
from collections.abc import Callable, Iterable
from itertools import pairwise
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PAGES = (ROOT / "README.md", ROOT / "bench" / "README.md")
MARKED = re.compile(r"(<!-- bench: ([^>]+?) -->\n).*?(<!-- /bench -->)", re.DOTALL)

Results = dict[str, Any]


def milliseconds(value: float) -> str:
    """Return a time in milliseconds to three digits."""
    return f"{value:.3g} ms" if value < 1000 else f"{value:.0f} ms"


def markdown(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> list[str]:
    """Return the lines of a table."""
    heads = list(heads)
    return [f"| {' | '.join(row)} |" for row in (heads, ["---"] * len(heads), *rows)]


def of_group(results: Results, group: str) -> list[Results]:
    """Return the benchmarks of a group."""
    found = [row for row in results["benchmarks"] if row["group"] == group]
    if not found:
        raise ValueError(f"no benchmark of the group {group!r} was run")
    return found


def measured(results: Results, groups: list[str]) -> list[str]:
    """Return medians with their errors, and how near the machine's limit they come."""
    rows = []
    for group in groups:
        for row in of_group(results, group):
            info = row["extra_info"]
            limit = f"{100 * info['share']:.0f}% of {info['bound']}" if "share" in info else ""
            time = milliseconds(1e3 * row["stats"]["median"])
            rows.append([group, info["work"], time, f"{info['error']:.1e}", limit])
    return markdown(["stage", "work", "median", "relative RMS error", "of the limit"], rows)


def machine(results: Results) -> list[str]:
    """Return the limits of the machine."""
    heads = ["threads", "float32", "float64", *(f"read {level}" for level in ("L1", "L2", "L3", "DRAM"))]
    rows = [
        [
            str(found["threads"]),
            *(f"{found[kind]:.0f} GFLOP/s" for kind in ("float", "double")),
            *(f"{speed:.0f} GB/s" for speed in found["read"].values()),
        ]
        for found in results["machine_info"]["limits"]
    ]
    return markdown(heads, rows)


def beside_the_prototype(results: Results) -> list[str]:
    """Return our kernels beside those of the timing study."""
    heads = ["work", "study, 1 thread", "ours", "ratio", "study, 2 threads", "ours", "ratio", "1 by 2"]
    rows = []
    for row in of_group(results, "beside the prototype")[0]["extra_info"]["rows"]:
        line = [row["work"]]
        for threads in (1, 2):
            line += [milliseconds(row[f"{whose} {threads}"]) for whose in ("study", "ours")]
            line.append(f"{row[f'ratio {threads}']:.2f}")
        rows.append([*line, f"{row['gain of the second thread']:.2f}"])
    return markdown(heads, rows)


def fourier(results: Results) -> list[str]:
    """Return the folded product beside FFTs, and an analysis as it is and as it would be with one."""
    heads = [
        "picture, F; 1 thread",
        "product",
        "scipy rfft",
        "planar",
        "numpy rfft",
        "16 columns",
        "analysis",
        "with rfft",
        "error",
    ]
    rows = []
    for bench in of_group(results, "Fourier"):
        for row in bench["extra_info"]["rows"]:
            times = ("product", "fft", "fft_planar", "numpy_fft", "legendre", "whole", "with_fft")
            rows.append(
                [
                    f"{row['W']} x {row['H']}, {row['F']}",
                    *(milliseconds(1e3 * row[name]) for name in times),
                    f"{row['error']:.1e}",
                ]
            )
    lines = [_crossing(bench["extra_info"]["rows"]) for bench in of_group(results, "Fourier")]
    return [*markdown(heads, rows), "", *lines]


def _crossing(rows: list[Results]) -> str:
    """Say from which degree on the FFT is faster, between the measured ones in proportion."""
    picture = f"{rows[0]['W']} x {rows[0]['H']}"
    for low, high in pairwise(rows):
        gains = [row["product"] - row["fft"] for row in (low, high)]
        if gains[0] <= 0 < gains[1]:
            F = low["F"] + (high["F"] - low["F"]) * gains[0] / (gains[0] - gains[1])
            saved, at = max((1 - row["with_fft"] / row["whole"], row["F"]) for row in rows)
            return (
                f"- {picture}: the FFT is faster from F = {F:.0f} on, and would take at the most "
                f"{100 * saved:.0f}% off an analysis (F = {at})."
            )
    return f"- {picture}: no degree measured is faster by FFT."


def kernels(results: Results) -> list[str]:
    """Return the hottest kernels, one thread, and how near the machine's limit they come."""
    rows = [
        [
            row["work"],
            milliseconds(row["ms"]),
            *(f"{row[unit]:.0f} {unit}" for unit in ("GFLOP/s", "GB/s")),
            f"{100 * row['share']:.0f}% of {row['bound']}",
        ]
        for row in of_group(results, "kernels")[0]["extra_info"]["rows"]
    ]
    return markdown(["call, 1 thread", "best", "arithmetic", "memory", "of the limit"], rows)


def methods(results: Results) -> list[str]:
    """Return all methods: what each keeps, costs and loses, and what for."""
    rows = [
        [
            row["method"],
            row["keeps"],
            row["material"],
            str(row["layers"]),
            f"{row['bytes'] / 1e6:.2g} MB",
            milliseconds(1e3 * row["seconds"]),
            f"{100 * row['error']:.2g}%",
            row["when"],
        ]
        for row in of_group(results, "methods")[0]["extra_info"]["rows"]
    ]
    heads = ["method", "keeps", "material", "maps", "memory", "prefiltering", "error", "choose it for"]
    return markdown(heads, rows)


def crossover(results: Results) -> list[str]:
    """Return the time of each method to a first map and to another, and which `auto` takes."""
    names = ("frequency", "angular", "hierarchical")
    heads = ["light", "GGX alpha", "F, P", *names, *(f"{name}, another view" for name in names), "auto"]
    rows = []
    for row in of_group(results, "crossover")[0]["extra_info"]["rows"]:
        first = [f"{milliseconds(1e3 * row[n]['seconds'])}, {100 * row[n]['error']:.2g}%" for n in names]
        again = [milliseconds(1e3 * row[n]["view"]) for n in names]
        rows.append([row["light"], f"{row['alpha']:g}", row["orders"], *first, *again, row["auto"]])
    return markdown(heads, rows)


def transfer_precomputation(results: Results) -> list[str]:
    """Return how long each stage of precomputation takes, and the most memory of the process."""
    found = of_group(results, "transfer precomputation")[0]["extra_info"]["rows"]
    stages = ("choosing tents", "materials", "rays", "bounces", "matrices", "components")
    rows = []
    for row in found:
        seconds = dict.fromkeys(stages, 0.0)
        for name, value in row["stages"].items():
            other = "components" if name.startswith("compressing") else "matrices"
            seconds[name if name in seconds else other] += value
        rows.append(
            [
                row["material"],
                ", ".join(row["variants"]),
                f"{row['M']} x {row['M']}, {row['SNR']:.1f} dB",
                ", ".join(str(K) for K in row["K"]),
                *(f"{seconds[name]:.1f} s" for name in stages),
                f"{row['seconds']:.0f} s",
                f"{row['bytes'] / 1e6:.0f} MB",
            ]
        )
    return markdown(["material", "variant", "tents", "K", *stages, "together", "memory"], rows)


def transfer_methods(results: Results) -> list[str]:
    """Return the ways to light an object with transfer: two numbers are with shadows and without."""
    by_method: dict[str, dict[bool, Results]] = {}
    for row in of_group(results, "transfer methods")[0]["extra_info"]["rows"]:
        by_method.setdefault(row["method"], {})[row["shadowed"]] = row

    def both(rows: dict[bool, Results], text: Callable[[Results], str]) -> str:
        said = [text(rows[shadowed]) if shadowed in rows else "" for shadowed in (True, False)]
        return " / ".join(one or "-" for one in said) if any(said) else ""

    rows = [
        [
            method,
            both(rows, lambda row: str(row["K"] or "")),
            both(rows, lambda row: _megabytes(row["bytes"])),
            both(rows, lambda row: f"{1 / row['seconds']:.0f}"),
            both(rows, lambda row: f"{row['paper']:g}" if row["paper"] else ""),
            both(rows, lambda row: f"{row['snr']:.1f}"),
            both(rows, lambda row: f"{row['published']:.1f}" if row["published"] else ""),
        ]
        for method, rows in by_method.items()
    ]
    speeds, errors = ["frames/s", "frames/s [LK03]"], ["SNR, dB", "published path, dB"]
    return markdown(["method", "K", "MB", *speeds, *errors], rows)


def _megabytes(count: int) -> str:
    if count < 1e4:
        return "0"
    return f"{count / 1e6:.0f}" if count >= 1e7 else f"{count / 1e6:.2g}"


def lighting(results: Results) -> list[str]:
    """Return frames per second of each way to light an object; ratios are times ours by the study's."""
    heads = ["way", "error"]
    for said in ("1 thread", "2 threads"):
        heads += [f"frames/s, {said}", "of the limit", "by the study"]
    rows = []
    for row in of_group(results, "lighting")[0]["extra_info"]["rows"]:
        line = [row["work"], f"{row['error']:.1e}"]
        for threads in (1, 2):
            line.append(f"{1e3 / row[f'ours {threads}']:.0f}")
            line.append(f"{100 * row[f'share {threads}']:.0f}% of {row[f'bound {threads}']}")
            line.append(f"{row[f'ratio {threads}']:.2f}" if f"ratio {threads}" in row else "")
        rows.append(line)
    return markdown(heads, rows)


def measured_materials(results: Results) -> list[str]:
    """Return real files of measurements: what they take, and their errors, measured by predicted."""
    found = of_group(results, "measured")[0]["extra_info"]["rows"]
    lights = list(found[0]["lights"])
    heads = ["material", "reading", "preparing", "memory", "prefiltering", "by GGX"]
    rows = []
    for row in found:
        under = [row["lights"][name] for name in lights]
        seconds, analytic = (sum(one[key] for one in under) / len(under) for key in ("seconds", "analytic"))
        rows.append(
            [
                row["material"],
                *(milliseconds(1e3 * row[key]) for key in ("reading", "preparing")),
                f"{row['bytes'] / 1e6:.0f} MB",
                milliseconds(1e3 * seconds),
                f"{seconds / analytic:.2f}",
                *(
                    f"{one['F']}, {one['P']}: {100 * one['predicted']:.2g}% / {100 * one['measured']:.2g}%"
                    for one in under
                ),
            ]
        )
    return markdown([*heads, *(f"{name}: F, P: predicted / measured" for name in lights)], rows)


TABLES = {
    "measured": measured_materials,
    "lighting": lighting,
    "methods": methods,
    "crossover": crossover,
    "transfer methods": transfer_methods,
    "transfer precomputation": transfer_precomputation,
    "machine": machine,
    "kernels": kernels,
    "beside the prototype": beside_the_prototype,
    "Fourier": fourier,
}


def written(results: Results, names: str) -> str:
    """Return the table that a marker names, under a line that says where it was measured."""
    asked = [name.strip() for name in names.split(",")]
    # Groups may come from several runs; the limits of the machine are those of the whole file
    rows = [row for row in results["benchmarks"] if row["group"] in asked] or results["benchmarks"]
    about = rows[0]["extra_info"]
    where = f"{about['machine']}, {about['threads']} threads, float32 RGB, commit {about['commit']}:"
    lines = TABLES[asked[0]](results) if asked[0] in TABLES else measured(results, asked)
    return "\n".join([where, "", *lines])


def main() -> int:
    if len(sys.argv) != 2:
        print("usage: python bench/report.py build/bench.json", file=sys.stderr)
        return 2
    results = json.loads(Path(sys.argv[1]).read_text())
    status = 0
    for page in PAGES:
        name, text = page.relative_to(ROOT), page.read_text()
        try:
            page.write_text(
                MARKED.sub(lambda found: f"{found[1]}\n{written(results, found[2])}\n\n{found[3]}", text)
            )
            print(f"{name}: {len(MARKED.findall(text))} tables")
        except ValueError as error:
            print(f"{name}: {error}", file=sys.stderr)
            status = 1
    return status


if __name__ == "__main__":
    sys.exit(main())
