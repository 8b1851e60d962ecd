"""A drawing of a test, written to a file."""

import ezdxf
import pytest
from sheets import FLOOR


@pytest.fixture
def sheet(tmp_path):
    """Draws what it is given in the model space of a new drawing, with a floor, and gives its path."""

    def draw(make, floor=True, version="R2010", **header):
        document = ezdxf.new(version)
        for name, value in header.items():
            document.header[f"${name}"] = value
        space = document.modelspace()
        if floor:
            space.add_lwpolyline(FLOOR, close=True, dxfattribs={"layer": "Supports"})
        make(space)
        path = tmp_path / "sheet.dxf"
        document.saveas(path)
        return path

    return draw
