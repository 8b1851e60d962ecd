"""Read all COMPAS files (.json) below some folders as scenes in space, and find their joints.

    git clone https://github.com/BlockResearchGroup/compas_assembly
    python benchmarks/samples.py compas_assembly

If a file names no supports, the lowest blocks are supports, or the first block if all blocks are equally low.
If a message recommends a tolerance, the file is read again with this tolerance.

The script prints a row for each file: the number of blocks, the numbers of joints and of contact points, and
the arguments with which the file was read. If the file is refused, the row contains the first line of the
message. The last line counts the files.
"""

import argparse
import re
from pathlib import Path
from typing import Any

import masonry_opt as mo

FRICTION = 0.7
#: Live load over weight.
PUSH = (1.0, 0.0, 0.0)
#: Height above the lowest corner, in the unit of the file, up to which blocks are supports.
FOOT = 0.02
#: Recommendation of a message to set a tolerance to a value.
TOLERANCE = re.compile(r"set '(contact_tolerance|tolerance)' to (\d[\d.e-]*\d)")
#: Part of the message about a file without supports, with the height of the lowest corner.
LOWEST = re.compile(r"the lowest corner is at z = (\S+)\)")
#: Part of the message about a file in which all blocks are supports, with the name of the first block.
ALL_FIXED = re.compile(r"every block is a support: .* \(blocks: ([^,)]+)")


def arguments_from(message: str) -> dict[str, Any]:
    """Return the arguments that a message recommends, or an empty dictionary."""
    if lowest := LOWEST.search(message):
        return {"fixed_below": round(float(lowest[1]) + FOOT, 4)}
    if first := ALL_FIXED.search(message):
        return {"fixed_below": None, "fixed": [first[1]]}
    tolerance = TOLERANCE.search(message)
    return {tolerance[1]: float(tolerance[2])} if tolerance else {}


def row_of(path: Path) -> tuple[bool, str]:
    """Return True if a file can be read, and the cells of its row."""
    given: dict[str, Any] = {}
    tried: list[dict[str, Any]] = []
    while True:
        try:
            scene = mo.read_compas(path, friction=FRICTION, unit_weight=1.0, live=PUSH, **given)
            assembly = mo.assemble(scene)
        except mo.MasonryError as error:
            further = arguments_from(str(error))
            tried.append(given)
            given = given | further
            if given in tried:
                return False, f"refused | | {str(error).splitlines()[0].removeprefix(f'{path}: ')}"
            continue
        words = ", ".join(f"{name}={value}" for name, value in given.items() if value is not None)
        counts = f"{len(scene.blocks)} blocks | {len(assembly.joints.first)}, {assembly.problem.joints}"
        return True, f"{counts} | {words}"


def main() -> None:
    """Read the files below the folders of the command line, and print the table."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument("folders", nargs="+", type=Path)
    for folder in parser.parse_args().folders:
        paths = sorted(path for path in folder.rglob("*.json") if path.stat().st_size)
        print("| file | blocks | joints, contact points | arguments, or message |\n|---|---|---|---|")
        read = 0
        for path in paths:
            is_read, cells = row_of(path)
            read += is_read
            print(f"| {path.relative_to(folder)} | {cells} |", flush=True)
        print(f"{folder}: {len(paths)} files, {read} read, {len(paths) - read} refused\n", flush=True)


if __name__ == "__main__":
    main()
