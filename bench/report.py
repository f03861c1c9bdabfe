"""Writes the README's measured table from what `./run bench` left in build/bench.json."""

import json
import sys
from pathlib import Path
from typing import Any

README = Path(__file__).resolve().parents[1] / "README.md"
BEGIN, END = "<!-- bench: written by bench/report.py -->", "<!-- /bench -->"


def table(results: dict[str, Any]) -> str:
    """Return Markdown: one row for each benchmark, in the order of the stages."""
    rows = results["benchmarks"]
    about = rows[0]["extra_info"]
    lines = [
        f"Medians on {about['machine']}, {about['threads']} threads, float32 RGB, commit {about['commit']}:",
        "",
        "| stage | work | median | relative RMS error |",
        "|---|---|---|---|",
    ]
    for row in rows:
        info = row["extra_info"]
        milliseconds = 1e3 * row["stats"]["median"]
        lines.append(f"| {row['group']} | {info['work']} | {milliseconds:.3g} ms | {info['error']:.1e} |")
    return "\n".join(lines)


def main() -> int:
    """Put the table between the markers of the README: `python bench/report.py build/bench.json`."""
    if len(sys.argv) != 2:
        print("usage: python bench/report.py build/bench.json", file=sys.stderr)
        return 2
    written = table(json.loads(Path(sys.argv[1]).read_text()))
    text = README.read_text()
    if BEGIN not in text or END not in text:
        print(f"{README.name}: the markers of the table are not there", file=sys.stderr)
        return 1
    before, rest = text.split(BEGIN, 1)
    after = rest.split(END, 1)[1]
    README.write_text(f"{before}{BEGIN}\n\n{written}\n\n{END}{after}")
    print(written)
    return 0


if __name__ == "__main__":
    sys.exit(main())
