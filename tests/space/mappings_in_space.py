"""Changes of a scene in space that leave λ unchanged, such as rotation, reflection and other units."""

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation
from touching_solids import in_triangles, moved

import masonry_opt as mo


def mapped(
    scene: mo.Scene,
    turn: np.ndarray | None = None,
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0),
    *,
    length: float = 1.0,
    force: float = 1.0,
    order: np.ndarray | None = None,
) -> mo.Scene:
    """Return the scene turned by an orthogonal matrix, moved, in other units, and with reordered blocks.

    If the determinant of the matrix is −1, the scene is mirrored. All faces are then clockwise, which the
    package accepts.
    """
    matrix = np.eye(3) if turn is None else turn

    def acting(block: mo.Solid) -> mo.Solid:
        forces = {
            "weight": block.weight and force * block.weight,
            "unit_weight": block.unit_weight and force / length**3 * block.unit_weight,
            "live": tuple((force * matrix @ block.live).tolist()),
            "live_per_weight": tuple((matrix @ block.live_per_weight).tolist()),
        }
        return block.model_copy(update=forces)

    blocks = [acting(block) for block in moved(scene, length * matrix, length * np.array(shift)).blocks]
    if order is not None:
        blocks = [blocks[index] for index in order]
    joints = scene.joints.model_copy(update={"cohesion": scene.joints.cohesion * force / length**2})
    gravity = (matrix @ scene.gravity).tolist()
    return mo.Scene(joints=joints, gravity=gravity, blocks=blocks)


TURN = Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()
MIRROR = np.diag([1.0, -1.0, 1.0])

#: Changes of a scene that leave λ unchanged.
SAME: dict[str, Callable[[mo.Scene], mo.Scene]] = {
    "moved": lambda scene: mapped(scene, shift=(31.7, -12.9, 8.3)),
    "turned": lambda scene: mapped(scene, TURN),
    "turned by 90°": lambda scene: mapped(scene, Rotation.from_rotvec([np.pi / 2, 0, 0]).as_matrix()),
    "mirrored": lambda scene: mapped(scene, MIRROR),
    "turned, mirrored and moved": lambda scene: mapped(scene, TURN @ MIRROR, (3.1, 4.1, -5.9)),
    "in other units": lambda scene: mapped(scene, length=1e3, force=1e-2),
    "renumbered": lambda scene: mapped(scene, order=np.random.default_rng(7).permutation(len(scene.blocks))),
    "faces in pieces": in_triangles,
}
