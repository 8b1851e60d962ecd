"""A fixture that writes a drawing to a file."""

import ezdxf
import pytest
from sheets import FLOOR


@pytest.fixture
def sheet(tmp_path):
    """Return a function that writes a new drawing and returns its path. The function calls its argument with
    the model space of the drawing, which contains a floor by default."""

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
