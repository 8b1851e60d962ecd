"""Numbers of a scene by name, against case files and scenes written with other numbers."""

import math

import pytest
from scenes import CASES, block_on_floor, two_blocks

import masonry_opt as mo
from masonry_opt.studies.many.parameters import Parameters

ON_PIERS = CASES / "examples" / "arch_on_piers.toml"


@pytest.fixture(scope="module")
def on_piers():
    return Parameters(mo.load(ON_PIERS))


@pytest.mark.parametrize(
    ("name", "written", "instead", "value"),
    [
        ("joints.friction", "friction_angle = 33", "friction = 0.5", 0.5),
        ("joints.friction_angle", "friction_angle = 33", "friction_angle = 20", 20.0),
        ("joints.cohesion", "friction_angle = 33", "friction_angle = 33\ncohesion = 2.0", 2.0),
        ("arch.thickness", "thickness = 0.4", "thickness = 0.3", 0.3),
        ("arch.voussoirs", "voussoirs = 12", "voussoirs = 14", 14.0),
        ("arch.live.y", "live = [1, 0]", "live = [1, 0.5]", 0.5),
        ("column.left buttress.width.2", "width = [1, 0.4]", "width = [1, 0.6]", 0.6),
        ("edge_load.1.force.y", "force = [0, -40]", "force = [0, -10]", -10.0),
        ("thickness", "thickness = 0.6", "thickness = 0.8", 0.8),
    ],
)
def test_a_number_set_is_the_number_written_in_the_file(on_piers, tmp_path, name, written, instead, value):
    text = ON_PIERS.read_text()
    changed = tmp_path / "changed.toml"
    # The first place is the one meant.
    changed.write_text(text.replace(written, instead, 1))
    expected = mo.load(changed)
    assert on_piers.at({name: value}) == expected
    assert expected != on_piers.scene


def test_values_are_set_together(on_piers):
    scene = on_piers.at({"arch.thickness": 0.3, "joints.friction_angle": 20.0, "joints.cohesion": 1.0})
    assert scene.joints.friction == math.tan(math.radians(20))
    assert scene.joints.cohesion == 1
    assert scene.blocks == on_piers.at({"arch.thickness": 0.3}).blocks


def test_joint_properties_leave_the_blocks_themselves(on_piers):
    scene = on_piers.at({"joints.friction": 0.3})
    assert all(one is other for one, other in zip(scene.blocks, on_piers.scene.blocks, strict=True))
    assert scene.origin == str(ON_PIERS)


def test_scenes_made_in_python_have_blocks_and_exceptions():
    parameters = Parameters(two_blocks())
    scene = parameters.at({"block.A.weight": 3.0, "block.A.live.y": 0.5, "joint.B/support.friction": 0.7})
    block = scene.blocks[0]
    assert (block.weight, block.live) == (3, (1, 0.5))
    assert scene.exceptions[0].friction == 0.7
    assert parameters.at({"block.A.unit_weight": 2.0}).blocks[0].weight is None


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("joints.frction", "joints.friction"),
        ("arch.thicknes", "arch.thickness"),
        ("column.left pier.hight", "column.left pier.height"),
        ("block.v1.weight", "arch.thickness"),  # the arch builds it
        ("nothing", "joints.friction"),
        ("joints.dilatancy_stress", "joints.dilatancy"),
        ("title", "joints.friction"),
    ],
)
def test_an_unknown_name_is_told_what_there_is(on_piers, name, near):
    with pytest.raises(mo.OptionError, match=near):
        on_piers.at({name: 1.0})


@pytest.mark.parametrize(
    ("name", "value"),
    [("arch.voussoirs", 12.5), ("arch.voussoirs", 13), ("arch.thickness", -1.0), ("joints.dilatancy", 2.0)],
)
def test_values_that_make_no_scene_are_named(on_piers, name, value):
    with pytest.raises(mo.CaseError, match=f"{name} = {value:g}"):
        on_piers.at({name: value})


def test_a_scene_changed_since_it_was_read_is_what_it_is_now(on_piers):
    read = on_piers.scene
    changed = read.model_copy(update={"blocks": block_on_floor().blocks, "edge_loads": []})
    parameters = Parameters(changed)
    assert "arch.thickness" not in parameters.names
    assert parameters.at({"block.A.weight": 2.0}).blocks[0].weight == 2


@pytest.mark.parametrize(
    "names", [("joints.friction", "joints.friction_angle"), ("block.A.unit_weight", "block.A.weight")]
)
def test_two_names_of_one_thing_are_refused(names):
    with pytest.raises(mo.OptionError, match=f"'{names[0]}' and '{names[1]}'|'{names[1]}' and '{names[0]}'"):
        Parameters(two_blocks()).at(dict.fromkeys(names, 0.5))
