"""Write the table of best known values in ``benchmarks/README.md``.

Run ``python tests/report/refresh_solver_people.py`` in the clone.
"""

import re
import tomllib
from pathlib import Path

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble

BETWEEN = re.compile(r"(<!-- best known -->\n)(.*?)(<!-- /best known -->)", re.DOTALL)


def table(cases: Path) -> str:
    """Return the table of the registry's case files, without its entries of scenes that ``compare`` makes."""
    lines = ["| case | blocks | joints | faces | λ | found by |", "|---|---|---|---|---|---|"]
    for name, entry in tomllib.loads((cases / "best_known.toml").read_text("utf-8")).items():
        if (cases / name).is_file():
            problem = assemble(mo.load(cases / name)).problem
            size = f"{problem.blocks} | {problem.joints} | {problem.faces}"
            case, value = name.removesuffix(".toml"), entry["load_factor"]
            lines.append(f"| `{case}` | {size} | {value:.9g} | {entry['method']} |")
    return "".join(f"{line}\n" for line in lines)


if __name__ == "__main__":
    page = Path("benchmarks", "README.md")
    written = table(Path("cases"))
    page.write_text(BETWEEN.sub(rf"\g<1>{written}\g<3>", page.read_text("utf-8")), "utf-8")
