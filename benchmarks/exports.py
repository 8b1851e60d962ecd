"""Export the programs of methods "mpec" and "global", and solve the files with IPOPT (CasADi) and HiGHS.

    python benchmarks/exports.py cases/gilbert/two_blocks.toml --programs mpec global
    python benchmarks/exports.py cases/ferris_tinloi/wall_*.toml --time-limit 60

IPOPT starts from the point in the file, with its default options. The script prints a row for each file: the
solver's status, the load factor relative to the lowest known one (cases/best_known.toml), and the processor
time of the solver.
"""

import argparse
import time
import tomllib
from pathlib import Path
from tempfile import TemporaryDirectory

import casadi
import highspy

import masonry_opt as mo

CASES = Path(__file__).parents[1] / "cases"


def solve_nl(path: Path, seconds: float) -> tuple[str, float]:
    """Solve an NL file with IPOPT, and return the status and the objective."""
    read = casadi.NlpBuilder()
    read.import_nl(str(path))
    program = {"x": casadi.vertcat(*read.x), "f": read.f, "g": casadi.vertcat(*read.g)}
    quiet = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False, "expand": True}
    solver = casadi.nlpsol("program", "ipopt", program, quiet | {"ipopt.max_cpu_time": seconds})
    found = solver(x0=read.x_init, lbx=read.x_lb, ubx=read.x_ub, lbg=read.g_lb, ubg=read.g_ub)
    return solver.stats()["return_status"], float(found["f"])


def solve_lp(path: Path, seconds: float) -> tuple[str, float]:
    """Solve an LP file with HiGHS, and return the status and the objective."""
    highs = highspy.Highs()
    highs.silent()
    highs.setOptionValue("time_limit", seconds)
    highs.setOptionValue("mip_rel_gap", 1e-9)
    highs.readModel(str(path))
    highs.run()
    return highs.modelStatusToString(highs.getModelStatus()), highs.getInfo().objective_function_value


#: End of the name of the file of each program, and function that solves the file.
SOLVERS = {"mpec": (".nl", solve_nl), "global": (".lp", solve_lp)}


def main() -> None:
    """Export and solve the programs of the command line, and print the table."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument("cases", nargs="+", type=Path)
    parser.add_argument("--programs", nargs="*", choices=list(SOLVERS), default=["mpec"])
    parser.add_argument("--time-limit", type=float, default=60.0, help="seconds of each program")
    asked = parser.parse_args()
    known = tomllib.loads((CASES / "best_known.toml").read_text("utf-8"))
    print("| program | case | status | λ over the lowest known - 1 | time (s) |\n|---|---|---|---|---|")
    for case in asked.cases:
        name = case.resolve().relative_to(CASES).as_posix()
        scene = mo.load(case)
        unit = mo.assemble(scene).problem.live_norm
        for program in asked.programs:
            end, solve = SOLVERS[program]
            with TemporaryDirectory() as folder:
                path, *_ = mo.export(scene, Path(folder, f"program{end}"), program)
                began = time.process_time()
                status, objective = solve(path, asked.time_limit)
                seconds = time.process_time() - began
            change = objective / unit / known[name]["load_factor"] - 1
            print(f"| `{program}` | {case.stem} | {status} | {change:.1e} | {seconds:.1f} |", flush=True)


if __name__ == "__main__":
    main()
