"""Refuse scenes that a method does not support, or that have no live load where one is needed."""

from masonry_opt.errors import CaseError, OptionError
from masonry_opt.methods.task import Method
from masonry_opt.problem.assembly import Assembly
from masonry_opt.scene.scene import Scene

#: Keys of a case file that define live loads, as part of a message, by dimension of the scene (2 or 3).
_LIVE_LOAD_KEYS = {
    2: "'live = [fx, fy]' in a block or a [[load]], 'live_per_weight' in a [wall], an [[edge_load]] of kind "
    '"live", an [earthquake], or \'tilt = "right"\' to tilt the ground',
    3: "'live = [fx, fy, fz]' in a block or a [[load]], 'live_per_weight', or 'tilt = [x, y, z]'",
}


def refuse_without_live_load(assembly: Assembly) -> None:
    """Raise CaseError if no block carries a live load."""
    if not assembly.problem.live_norm:
        raise CaseError(f"{assembly.scene.origin}: {_without_live_load(assembly.scene)}")


def asks_for_stability(assembly: Assembly) -> bool:
    """Return True if a scene has no live load, so the analysis must decide if the scene is stable.

    Axles that move, and a load case, are live loads even if they act on no block.

    Raises CaseError if the scene has no dead load either.
    """
    scene = assembly.scene
    has_live_load = assembly.problem.live_norm or scene.load_case or (scene.factor_of_axles and scene.axles)
    if has_live_load:
        return False
    if not assembly.problem.dead.any():
        raise CaseError(
            f"{scene.origin}: no block carries a load: give the blocks a 'weight' or 'unit_weight', and "
            "'live' loads that grow until collapse"
        )
    return True


def refuse_unsuited(method: Method, assembly: Assembly) -> None:
    """Raise an error if a method cannot solve a scene.

    Raises
    ------
    OptionError
        If the scene has load cases and none was named. If the method does not support solids, limited forces,
        limited strength, or dilatancy that falls with stress.
    """
    problem, scene = assembly.problem, assembly.scene
    scene.refuse_without_case()
    named = f"method '{method.name}'"
    if scene.dimension == 3 and "space" in method.refuses:
        raise OptionError(f"{scene.origin}: {named} does not support scenes in space: choose another method")
    roles = ", ".join(dict.fromkeys(f"'{force.role}'" for force in assembly.limited))
    dilatancy = (
        f"{named} does not support dilatancy that falls with stress: use method 'nonassociative', or omit "
        "'dilatancy_stress'"
    )
    forces = f"{named} does not support forces of limited size ({roles}): choose another method, or omit them"
    strength = f"{named} does not support joint strength: choose another method, or omit 'strength'"
    for feature, is_present, sentence in (
        ("dilatancy", problem.dilatancy_depends_on_stress, dilatancy),
        ("forces", problem.matrices.limited, forces),
        ("strength", len(problem.crushing), strength),
    ):
        if is_present and feature in method.refuses:
            raise OptionError(sentence)


def _without_live_load(scene: Scene) -> str:
    """Return an error message, with a remedy, for a scene in which no block carries a live load."""
    case = scene.load_case
    prefix = f"load case '{case.name}': " if case is not None else ""
    if scene.factor_of_axles and (scene.axles or case is not None):
        return (
            f"{prefix}the only live loads are axles that move: use 'crossing' (in Python mo.crossing), "
            "which finds the worst position of the axles"
        )
    if case is not None:
        return (
            f"{prefix}none of the live loads ({case}) acts on a block: name other load groups in this load "
            "case, or add loads to its groups"
        )
    return (
        f"no block carries a live load: add {_LIVE_LOAD_KEYS[scene.dimension]}. For a scene without "
        "live load, use 'solve' to decide if it is stable, or 'least' to vary a parameter until it is stable"
    )
