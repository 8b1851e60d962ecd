"""The package as a whole: its public names, the modules that it imports, and the files that it needs."""

import ast
import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from importlib.metadata import version

import pytest
from sources import ROOT, imports_of

import masonry_opt as mo

PACKAGE = ROOT / "masonry_opt"


def in_a_process_of_its_own(program, *arguments, **keys):
    """Return the standard output of a Python program that runs in a new process."""
    command = [sys.executable, "-c", program, *arguments]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=120, **keys)
    assert ran.returncode == 0, ran.stderr
    return ran.stdout.strip()


def test_names_are_those_announced():
    assert dir(mo) == mo.__all__ == sorted(mo.__all__)
    for name in mo.__all__:
        assert getattr(mo, name).__name__ == name
    with pytest.raises(AttributeError, match="no attribute 'Finding'"):
        mo.Finding  # noqa: B018
    starred: dict[str, object] = {}
    exec("from masonry_opt import *", starred)
    assert sorted(set(starred) - {"__builtins__"}) == mo.__all__


def test_type_checkers_are_told_the_same_names_from_the_same_modules():
    stub = ast.parse((PACKAGE / "__init__.pyi").read_text(encoding="utf-8"))
    _, package_version, *imports = stub.body
    assert ast.unparse(package_version) == "__version__: str"
    homes = [(alias.asname, node.module) for node in imports for alias in node.names]
    assert sorted(homes) == sorted(mo._HOMES.items())


def test_the_package_states_its_version():
    assert mo.__version__ == version("masonry_opt")


#: Subpackages in the order in which they build on each other.
LAYERS = (
    *("scene", "problem", "models", "solvers", "solution", "stability", "methods"),
    *("reporting", "drawing", "finite_motion", "exports", "studies", "cli"),
)
#: Modules that combine the subpackages before "exports", which do not import these modules.
COMBINING = {"analysis", "certifying", "duality", "proof_check", "proving", "standing", "suitability"}
#: Further subpackages and modules that a subpackage or a module must not import.
REFUSED = {
    "reporting": {"methods"},  # it describes the results of any method
    "analysis.py": {"reporting", "drawing", "exports", "duality"},  # it is part of every analysis
}


def test_no_subpackage_imports_a_later_one():
    """Modules beside the subpackages may import all of them except studies and the command line.

    Only the module that runs with ``python -m masonry_opt`` imports the command line.
    """
    folders = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").exists()}
    assert {*LAYERS} == {*folders, "models"}
    for path in {*PACKAGE.rglob("*.py")} - {PACKAGE / "__main__.py"}:
        place = path.relative_to(PACKAGE).parts[0]
        number = LAYERS.index(place) if place in LAYERS else LAYERS.index("exports")
        refused = {*LAYERS[number + 1 :]} | REFUSED.get(place, set())
        if number < LAYERS.index("exports"):
            refused |= COMBINING
        imported = {name.split(".")[1] for name in imports_of(path) if name.startswith("masonry_opt.")}
        assert not imported & refused, path


def test_results_import_drawing_on_request():
    """Only functions of the module of results import the subpackage of pictures, which takes long."""
    at_once = imports_of(PACKAGE / "result.py", within=lambda tree: tree.body)
    assert not [name for name in at_once if name.startswith("masonry_opt.drawing")]


def test_models_know_the_problem_and_each_other_alone():
    for path in (ROOT / "models").glob("*.py"):
        own = {name for name in imports_of(path) if name.startswith("masonry_opt")}
        assert not [name for name in own if name.split(".")[1] not in ("models", "problem")]


@pytest.fixture
def copied(tmp_path):
    """Return a folder with the package and its models, as in a clone, and with a case file."""
    for name in ("masonry_opt", "models"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "cases" / "gilbert" / "two_blocks.toml", tmp_path)
    return tmp_path


#: Packages whose import takes seconds.
DEAR = ("cvxpy", "pyomo", "casadi", "highspy", "matplotlib", "altair")

#: Program that prints the imported modules, λ of the loop, and the folders of the package and its models. The
#: modules are listed after names, a linear program and method "coulomb" were used.
IN_A_CLONE = """
import json, sys
import masonry_opt as mo
def loaded():
    return sorted(sys.modules)
mo.solve, mo.load, mo.save, mo.check, mo.Scene, mo.Result
imported = [loaded()]
for method in ("static", "coulomb"):
    mo.solve("two_blocks.toml", method)
    imported.append(loaded())
load_factor = mo.solve("two_blocks.toml", "nonassociative").load_factor
drawing = loaded()
import masonry_opt.cli.app
from masonry_opt.models import cvxpy_terms
print(json.dumps([imported, load_factor, drawing, loaded(), mo.__file__, cvxpy_terms.__file__]))
"""


@pytest.mark.slow
def test_python_started_in_a_clone_finds_the_models_there_and_loads_what_it_uses(copied):
    """In a clone, Python finds the models without a search path, whatever else is installed. A modelling
    language is imported only with a program declared in it. No solve imports pictures or IPOPT, and no
    command imports studies."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    printed = in_a_process_of_its_own(IN_A_CLONE, cwd=copied, env=environment)
    imported, load_factor, solved, by_command, package, models = json.loads(printed)
    assert load_factor == pytest.approx(0.15, rel=1e-3)
    assert package == str(copied / "masonry_opt" / "__init__.py")
    assert models == str(copied / "models" / "cvxpy_terms.py")
    names, static, mcp = ([name for name in DEAR if name in known] for known in imported)
    assert names == []
    assert static == ["cvxpy", "highspy"]
    assert mcp == ["cvxpy", "highspy"]
    of_drawing = ("masonry_opt.drawing", "matplotlib")
    assert not [name for name in solved if name.startswith(of_drawing)]
    assert not [name for name in by_command if name.startswith(("masonry_opt.studies", "altair"))]


def test_the_package_runs_as_a_module():
    ended = subprocess.run([sys.executable, "-m", "masonry_opt", "--version"], cwd=ROOT, capture_output=True)
    assert (ended.returncode, ended.stdout.split(), ended.stderr) == (
        0,
        [version("masonry_opt").encode()],
        b"",
    )


def test_hints_install_extras_of_the_clone():
    """Hints install the extras from the clone, because the public index has no package of this name."""
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    hints = [
        hint
        for path in [*PACKAGE.rglob("*.py"), *(ROOT / "docs").glob("*.md"), ROOT / "README.md"]
        for hint in re.findall(r"pip install '([^']*)'", path.read_text(encoding="utf-8"))
    ]
    assert len(hints) > 8
    for hint in hints:
        assert re.fullmatch(r"\.\[[\w,]+\]", hint)
        assert set(hint[2:-1].split(",")) <= set(extras)


def test_every_package_and_file_of_the_tree_is_in_the_wheel():
    """In pyproject.toml, folders and files that are not modules are listed by hand. The lists must be
    complete."""
    setuptools = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    found = {".".join(path.parent.relative_to(ROOT).parts) for path in PACKAGE.rglob("__init__.py")}
    assert found | {"masonry_opt.models"} <= set(setuptools["packages"])
    for name in setuptools["packages"]:
        assert (ROOT / setuptools["package-dir"].get(name, name.replace(".", "/"))).is_dir()
    listed = {
        path
        for package, patterns in setuptools["package-data"].items()
        if package != "masonry_opt.cases"
        for pattern in patterns
        for path in ROOT.joinpath(*package.split(".")).glob(pattern)
    }
    there = {path for path in PACKAGE.rglob("*") if path.is_file() and path.suffix not in (".py", ".pyc")}
    assert there == listed


#: Program that prints the modules that the command line and its list of commands import.
LISTED = """
import json, sys, masonry_opt.cli
import masonry_opt.cli.app as app
try:
    app.app(["--help"])
except SystemExit:
    print(json.dumps(list(sys.modules)))
"""


def test_the_commands_are_listed_without_running_or_waiting():
    *listed, modules = in_a_process_of_its_own(LISTED, cwd=ROOT).splitlines()
    assert "settle" in "".join(listed)
    assert not {*DEAR, "pandas", "scipy", "numpy", "shapely"} & set(json.loads(modules))


#: Program that runs the command "solve" on cases with its default method, then prints the imported modules.
SOLVED = """
import json, sys, masonry_opt.cli
import masonry_opt.cli.app as app
for case in sys.argv[1:]:
    try:
        app.app(["solve", case])
    except SystemExit as ended:
        assert not ended.code
print(json.dumps(list(sys.modules)))
"""


@pytest.mark.slow
def test_a_default_solve_imports_only_what_its_steps_use():
    """For scenes in the plane, no modelling language, tables, pictures or studies are imported.

    On wall 6 displacement control fails, and two optimisation programs find the exact state of the collapse.
    """
    cases = [str(ROOT / "cases" / f"{name}.toml") for name in ("gilbert/two_blocks", "ferris_tinloi/wall_6")]
    *printed, modules = in_a_process_of_its_own(SOLVED, *cases, cwd=ROOT).splitlines()
    assert printed.count("load factor λ") == len(cases)
    imported = set(json.loads(modules))
    assert not {"cvxpy", "pyomo", "pandas", "matplotlib", "altair", "casadi", "sklearn"} & imported
    assert not [name for name in imported if name.startswith("masonry_opt.studies")]
