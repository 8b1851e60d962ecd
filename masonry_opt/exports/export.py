"""Function ``export``: the optimisation program of a method as a file for other solvers.

Programs are written by :mod:`.programs`, solids by :mod:`.solid_files`. The clauses of a proof are written in
DIMACS format for SAT solvers.
"""

from pathlib import Path

from masonry_opt.errors import OptionError, OutputError
from masonry_opt.exports.header import comments, header
from masonry_opt.exports.solid_files import SOLID_ENDS, solid_file
from masonry_opt.files import refuse_unwritable, write_together
from masonry_opt.problem.assembly import assemble
from masonry_opt.result import Result
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.mistakes import suggests_arguments
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.tables import write_file

CLAUSES_END = ".cnf"  #: File ending of the clauses of a proof in DIMACS format.


@suggests_arguments
def export(
    scene: Scene | Result | str | Path,
    path: str | Path,
    method: str | None = None,
    force: bool = False,
    *,
    moved: float | None = None,
) -> tuple[Path, ...]:
    """Write the optimisation program of a method, the clauses of a proof, or solids to a file.

    In the file of a program, rows and columns are named by their kind and their blocks. The units are those
    of the problem that ``mo.assemble`` returns, and λ is that of the scene. The page "For solver people" of
    the guide describes the files.

    Solids are written in the units of the case. OBJ and glTF files have one object for each block; the names
    of supports begin with ``fixed``. COMPAS JSON is an assembly of compas_assembly: blocks at rest, joints as
    interfaces with forces at their contact points, velocities as displacements.

    Parameters
    ----------
    scene: A scene, or the path of a case file; for solids also a result, with its motion and forces.
    path: File to write, whose ending selects the format.

        - ``.lp``, ``.mps`` or ``.nl``: linear programs, also with binary variables.
        - ``.nl`` only: programs with products or complementary pairs. The names of rows and columns are
          written to a ``.row`` and a ``.col`` file.
        - ``.cnf``: the clauses of a proof that no state has a lower load factor, for SAT solvers; see
          :func:`~masonry_opt.prove_least`.
        - ``.obj``, ``.glb`` or ``.gltf`` (both with trimesh, of the extra "meshes"), or ``.json`` (COMPAS):
          solids.
    method: Method whose program is written: "static", eq. (9), the default; "kinematic", eq. (10); "global"
        (complementarity with a binary for each face; its bounds are computed first, by linear programs);
        "mpec" (with products z p ≤ 10⁻⁶); or "mcp" (with complementary pairs).
    force: True to replace files of other programs; files of this package have a mark and are replaced.
    moved: Fraction of the full motion of a result by which its meshes are displaced: 0 for blocks at rest, 1
        for the largest motion of a page. The default is the motion that pictures show.

    Returns
    -------
    tuple of pathlib.Path
        The files, each written completely.

    Raises
    ------
    CaseError
        If the case file or the scene is wrong, or no block that can move has a live load.
    OptionError
        If the method has no single program or does not support the joints of the scene; if the format cannot
        contain the program; if a file cannot be replaced; if solids of a plane scene are asked for; if
        clauses are asked for and there is no proof.
    OutputError
        If a file cannot be written.
    NoLoadFactorError
        If there is no associative load factor that bounds λ of the program of "global".
    """
    if not isinstance(path, str | Path):
        raise OptionError(f"the path of a file must be text or a pathlib.Path (found {path!r})")
    path = Path(path)
    ending = path.suffix.lower()
    if ending in SOLID_ENDS:
        if method is not None:
            raise OptionError(
                f"{path}: 'method' cannot be used for a file of solids: omit 'method'; to write the "
                "mechanism of a method, pass its result"
            )
        refuse_unwritable(path, force)
        solids = scene if isinstance(scene, Result) else as_scene(scene)
        write_file(path, solid_file(solids, ending, moved), OutputError)
        return (path,)
    if moved is not None:
        raise OptionError(
            f"{path}: 'moved' can be used only for mesh files ({', '.join(SOLID_ENDS[1:])}): omit 'moved'"
        )
    if ending == CLAUSES_END:
        if method is not None:
            raise OptionError(f"{path}: 'method' cannot be used for the clauses of a proof: omit 'method'")
        refuse_unwritable(path, force)
        write_file(path, _clauses(path, scene).encode("ascii"), OutputError)
        return (path,)
    # The import is local, because it imports Pyomo and CVXPY, which takes seconds.
    from masonry_opt.exports.programs import program_texts, refuse_program

    method = method or "static"
    refuse_program(path, method, force)
    assembly = assemble(scene.assembly.scene if isinstance(scene, Result) else as_scene(scene))
    texts = program_texts(assembly, method, ending)
    paths = {end: path.with_suffix(path.suffix if end == ending else end) for end in texts}
    write_together({paths[end]: text for end, text in texts.items()})
    return tuple(reversed(paths.values()))


def _clauses(path: Path, scene: Scene | Result | str | Path) -> str:
    """Return the clauses of a proof as the text of a DIMACS file, with a comment for each variable.

    If a result has a proof by conflicts alone, this proof is written; otherwise such a proof is searched for.
    Raises OptionError if no proof is found.
    """
    proof, why = None, ""
    if isinstance(scene, Result):
        assembly, proof = scene.assembly, scene.proof
    else:
        assembly = assemble(as_scene(scene))
    if proof is None or proof.relaxations:
        # The import is local, because it imports HiGHS and a SAT solver.
        from masonry_opt.proving import prove_least

        answer = prove_least(assembly.scene, products=False)
        proof, why = answer.proof, answer.why
    if proof is None:
        raise OptionError(f"{path}: the clauses cannot be written, because no proof was found: {why}")
    conditions = assembly.problem_names(legal=True).conditions
    faces = [f"variable {number}: {condition}" for number, condition in enumerate(conditions, 1)]
    return comments("c", [*header("clauses of a proof", assembly), *faces]) + proof.to_dimacs()
