"""What leaves a scene in space the same: turned, mirrored, in other units, renumbered, faces in pieces."""

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

import masonry_opt as mo
from masonry_opt.scene.solids import Polyhedron


def mapped(
    scene: mo.Scene,
    turn: np.ndarray | None = None,
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0),
    *,
    length: float = 1.0,
    force: float = 1.0,
    order: np.ndarray | None = None,
    pieces: bool = False,
) -> mo.Scene:
    """The scene turned by an orthogonal matrix, mirrored where its determinant is −1, moved, in other units,
    its blocks in another order, each face in two pieces. For scenes of unit weights and live loads by
    weight."""
    matrix = np.eye(3) if turn is None else turn

    def vector(of: tuple[float, ...]) -> list[float]:
        return (matrix @ of).tolist()

    blocks = []
    for block in scene.blocks:
        [shape] = block.polyhedra
        corners, faces = in_pieces(shape) if pieces else shape
        # Orders of corners are then all clockwise, which is one way to give them.
        keys = {} if block.fixed else {"unit_weight": block.unit_weight * force / length**3}
        blocks.append(
            mo.Solid(
                name=block.name,
                fixed=block.fixed,
                vertices=(length * (corners @ matrix.T + shift)).tolist(),
                faces=faces,
                live_per_weight=vector(block.live_per_weight),
                **keys,
            )
        )
    if order is not None:
        blocks = [blocks[index] for index in order]
    cohesion = scene.joints.cohesion * force / length**2
    joints = scene.joints.model_copy(update={"cohesion": cohesion})
    return mo.Scene(joints=joints, gravity=vector(scene.gravity), blocks=blocks)


def in_pieces(shape: Polyhedron) -> Polyhedron:
    """Each face of four corners cut in two along a diagonal."""
    faces = []
    for a, b, c, d in shape.faces:
        faces += [[a, b, c], [a, c, d]]
    return Polyhedron(shape.vertices, faces)


TURN = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()
MIRROR = np.diag([1.0, -1.0, 1.0])

#: What leaves λ as it is.
SAME: dict[str, Callable[[mo.Scene], mo.Scene]] = {
    "moved": lambda scene: mapped(scene, shift=(31.7, -12.9, 8.3)),
    "turned": lambda scene: mapped(scene, TURN),
    "turned by 90°": lambda scene: mapped(scene, Rotation.from_rotvec([np.pi / 2, 0, 0]).as_matrix()),
    "mirrored": lambda scene: mapped(scene, MIRROR),
    "turned, mirrored and moved": lambda scene: mapped(scene, TURN @ MIRROR, (3.1, 4.1, -5.9)),
    "in other units": lambda scene: mapped(scene, length=1e3, force=1e-2),
    "renumbered": lambda scene: mapped(scene, order=np.random.default_rng(7).permutation(len(scene.blocks))),
    "faces in pieces": lambda scene: mapped(scene, pieces=True),
}
