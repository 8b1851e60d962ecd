"""Files that are not what their names say, and mistakes of TOML and JSON, are named with a remedy."""

import json

import pytest
from scenes import CASES

import masonry_opt as mo
from masonry_opt.scene.syntax_advice import advice_on_line

GOOD = """[joints]
friction = 0.6

[[block]]
name = "base"
vertices = [[0, -1], [4, -1], [4, 0], [0, 0]]
fixed = true

[[block]]
name = "A–B, 0,5 // 'x'"
vertices = [[0, 0], [1, 0], [1, 1], [0, 1]]
weight = 1.0
live = [1.0, 0.0]
"""

#: Mistakes in a TOML file: a text of the correct file, its replacement, the line, and the advice.
TOML = {
    "typographic quotation marks": ('"base"', "“base”", 5, "use straight quotation marks"),
    "a typographic minus sign": ("-1]", "\N{MINUS SIGN}1]", 6, "write a minus sign as '-'"),
    "a no-break space": ("weight =", "weight\u00a0=", 12, "replace the Unicode space by"),
    "a colon": ("friction =", "friction:", 2, "write '=' between key and value"),
    "a decimal comma": ("0.6", "0,6", 2, "write numbers with a decimal point"),
    "no digit before the point": ("0.6", ".6", 2, "write a digit before the decimal point"),
    "no digit after the point": ("1.0\n", "1.\n", 12, "write a digit after the decimal point"),
    "a unit after an exponent": ("weight = 1.0", "weight = 1e5 kN", 12, "write numbers without a unit"),
    "a unit": ("weight = 1.0", "weight = 1.0 kN", 12, "write numbers without a unit"),
    "a truth value of Python": ("true", "True", 7, "write true or false"),
    "a path of Windows": ('"base"', '"C:\\Users\\base"', 5, "write paths with '/'"),
    "text without quotation marks": ('"base"', "base", 5, "write text between quotation marks"),
    "no value": ("= 1.0", "=", 12, "write a value after '='"),
    "a key alone": ("weight = 1.0", "weight", 12, "write 'key = value'"),
    "a table twice": (
        '[[block]]\nname = "A',
        '[joints]\nname = "A',
        9,
        "write [[name]] for each table of a list",
    ),
}

#: Valid lines of TOML that could be taken for mistakes: numbers, truth values, a date, texts and comments.
VALID = {
    "a number": "friction = 0.6",
    "an exponent": "friction = 1e-3",
    "a whole number": "friction = 1_000",
    "a hexadecimal number": "friction = 0x1F",
    "an infinite number": "friction = inf",
    "a truth value": "fixed = true",
    "a date": "day = 1979-05-27T07:32:00",
    "a path": "path = 'C:\\stones'",
    "a comment": "friction = 0.6  # 0,6 – “about” .5 or 3 kN",
    "a comment alone": "# friction: 3 kN, or friction = 1.",
    "an inline table": "{ at = [0, 1] },",
}

#: Mistakes in a line of TOML for which there is no advice.
WITHOUT_ADVICE = {
    "an open text": 'x = "a',
    "an empty entry": "x = [1,,2]",
    "two texts": 'name = "a" "b"',
    "an apostrophe": "x = 'don't'",
    "separated thousands": "x = 1,000.5",
    "two equals signs": "x = 1 = 2",
    "a bracket too many": "x = [1]]",
}

#: Mistakes in a JSON file, and the advice.
JSON = {
    "typographic quotation marks": ("{“joints”: 1}", "use straight quotation marks"),
    "TOML": (GOOD, "the file contains TOML: give it a name that ends in .toml"),
    "a comment": ('{"joints": 1, // μ\n "block": []}', "remove comments"),
    "a comma at the end of a list": ('{"block": [\n1,\n]}', "remove the comma before the bracket"),
    "a comma at the end of an object": ('{"block": {"a": 1,}}', "remove the comma before the bracket"),
    "single quotation marks": ("{'joints': 1}", "between double quotation marks"),
    "a decimal comma": ('{"weight": 0,5}', "write numbers with a decimal point"),
    "no digit before the point": ('{"weight": .5}', "write a digit before the decimal point"),
    "a truth value of Python": ('{"fixed": True}', "write true, false or null"),
}

#: Beginnings of files of other kinds, and the remedy.
OTHERS = {
    "Git LFS": (
        b"version https://git-lfs.github.com/spec/v1\noid sha256:12\nsize 9\n",
        "with 'git lfs pull'",
    ),
    "a web page": (b"\n<!DOCTYPE HTML>\n<html></html>", "is a web page: download the file itself"),
    "a web page without type": (b"<html lang='en'></html>", "is a web page: download the file itself"),
    "ZIP": (b"PK\3\4" + bytes(40), "is a ZIP archive: unpack it"),
    "gzip": (b"\x1f\x8b" + bytes(40), "is compressed: unpack it"),
    "DWG": (b"AC1032\0" + bytes(400), "is a DWG drawing: save the drawing as DXF"),
}
READERS = {
    ".toml": mo.load,
    ".json": mo.load,
    ".dxf": lambda path: mo.read_dxf(path, friction=0.6, unit_weight=1),
    **{
        ending: lambda path: mo.read_mesh(path, friction=0.6, unit_weight=1)
        for ending in (".obj", ".ply", ".stl", ".glb", ".gltf")
    },
}


def refusal(path, content, read=mo.load):
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(mo.CaseError) as error:
        read(path)
    message = str(error.value)
    assert message.startswith(f"{path}: ")
    return message


def test_the_correct_file_is_read(tmp_path):
    """Strings in the file contain characters that are special in TOML. The block still slides at λ = μ."""
    path = tmp_path / "case.toml"
    path.write_text(GOOD)
    assert mo.solve(path, "static").required() == pytest.approx(0.6, rel=1e-6)


@pytest.mark.parametrize(("old", "new", "line", "advice"), TOML.values(), ids=TOML)
def test_mistakes_of_toml_are_named_with_line_and_advice(tmp_path, old, new, line, advice):
    assert old in GOOD
    message = refusal(tmp_path / "case.toml", GOOD.replace(old, new, 1))
    assert "the file is not valid TOML: " in message
    assert f"line {line}, " in message
    assert advice in message


@pytest.mark.parametrize("before", VALID.values(), ids=VALID)
def test_the_line_before_a_mistake_of_toml_has_no_effect(before):
    """Each mistake gets its own advice or none, whatever valid line is before it."""
    for old, new, line, advice in TOML.values():
        if new.startswith("[joints]"):  # the parser words its error about a repeated table differently
            continue
        mistake = GOOD.replace(old, new, 1).splitlines()[line - 1]
        assert advice in advice_on_line(
            f"{before}\n{mistake}\n", "Invalid value (at line 2, column 1)", ".toml"
        )
    for mistake in WITHOUT_ADVICE.values():
        assert not advice_on_line(f"{before}\n{mistake}\n", "(at line 2, column 1)", ".toml")


@pytest.mark.parametrize("after", VALID.values(), ids=VALID)
def test_an_array_that_is_not_closed_has_no_false_advice(tmp_path, after):
    """The parser names a valid line after the array."""
    content = f"[joints]\nfriction = 0.6\nvertices = [[0, 0], [1, 0]\n{after}\n"
    assert refusal(tmp_path / "a.toml", content).endswith(")")
    assert refusal(tmp_path / "b.toml", f"{after}\nvertices = [[0, 0], [1, 0]").endswith(")")


@pytest.mark.parametrize("mistake", WITHOUT_ADVICE.values(), ids=WITHOUT_ADVICE)
def test_mistakes_after_a_number_are_not_taken_for_units(tmp_path, mistake):
    message = refusal(tmp_path / "a.toml", f"[joints]\nfriction = 0.6\n{mistake}\n")
    assert "the file is not valid TOML: " in message
    assert message.endswith(")")


def test_json_in_a_toml_file_is_named(tmp_path):
    message = refusal(tmp_path / "case.toml", '{"joints": {"friction": 0.6}}')
    assert message.endswith(": the file contains JSON: give it a name that ends in .json")


@pytest.mark.parametrize(("content", "advice"), JSON.values(), ids=JSON)
def test_mistakes_of_json_are_named_with_advice(tmp_path, content, advice):
    message = refusal(tmp_path / "case.json", content)
    assert "the file is not valid JSON: " in message
    assert advice in message


@pytest.mark.parametrize(("ending", "content"), [(".toml", "x = 1 = 2"), (".json", '{"x"'), (".json", "")])
def test_other_mistakes_have_no_advice(tmp_path, ending, content):
    message = refusal(tmp_path / f"case{ending}", content)
    assert message.endswith(")")


@pytest.mark.parametrize("ending", READERS)
@pytest.mark.parametrize(("content", "remedy"), OTHERS.values(), ids=OTHERS)
def test_files_of_other_kinds_are_named(tmp_path, content, remedy, ending):
    assert remedy in refusal(tmp_path / f"a{ending}", content, READERS[ending])


def test_results_and_compas_data_are_no_case_files(tmp_path):
    result = mo.solve(CASES / "ferris_tinloi" / "wall_1.toml", "static").to_json()
    text = result if isinstance(result, str) else json.dumps(result)
    assert "this is the result of an analysis" in refusal(tmp_path / "a.json", text)
    compas = '{"dtype": "compas_assembly.datastructures/Assembly", "data": {}}'
    assert "this is COMPAS data: convert it to a case file" in refusal(tmp_path / "b.json", compas)
