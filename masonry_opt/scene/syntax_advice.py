"""Advise how to correct a file that is not what its name says, or a line that is not valid TOML or JSON."""

import re

#: Beginnings of files of other kinds, each with the reason why such a file cannot be read, and a remedy.
_OTHER_CONTENTS = (
    (
        rb"version https://git-lfs\.github\.com/",
        "the file is a pointer of Git LFS instead of the content: fetch the content with 'git lfs pull'",
    ),
    (
        rb"(?:\xef\xbb\xbf)?\s*<(?:!doctype html|html)\b",
        "the file is a web page: download the file itself",
    ),
    (rb"PK\x03\x04", "the file is a ZIP archive: unpack it"),
    (rb"\x1f\x8b", "the file is compressed: unpack it"),
    (rb"AC10\d\d\0", "the file is a DWG drawing: save the drawing as DXF"),
)

#: Patterns of frequent mistakes in a line of TOML, each with advice. The first pattern that fits is used.
_TOML_ADVICE = (
    (r"[“”„‘’‚«»]", "use straight quotation marks"),
    (r"[−–—]", "write a minus sign as '-'"),
    (r"[\u00a0\u2000-\u200b\u202f\ufeff]", "replace the special space by an ordinary one"),
    (r"^\s*[{]", "the file contains JSON: give it a name that ends in .json"),
    (r"^\s*[\w-]+\s*:", "write '=' between key and value"),
    (r"=\s*[-+]?\d+,\d+\s*(?:#|$)", "write numbers with a decimal point"),
    (r"(?:[=\[,]\s*|[-+])\.\d", "write a digit before the decimal point"),
    (r"(?:[=\[,]\s*)[-+]?\d+\.\s*(?:[,\]#]|$)", "write a digit after the decimal point"),
    (r"=\s*[-+]?\d[\d.]*\s*[^\W\d_]", "write numbers without a unit"),
    (r"=\s*(?:True|False|TRUE|FALSE|[Yy]es|[Nn]o)\b", "write true or false"),
    (r"\"[^\"]*\\", "write paths with '/', or between single quotation marks"),
    (r"=\s*[^\W\d_]", "write text between quotation marks"),
    (r"=\s*(?:#|$)", "write a value after '='"),
    (r"^\s*[^\W\d_][\w-]*\s*(?:#|$)", "write 'key = value'"),
)

#: Patterns of frequent mistakes in a line of JSON, each with advice. The first pattern that fits is used.
_JSON_ADVICE = (
    (r"[“”„‘’‚«»]", "use straight quotation marks"),
    (r"^\s*\[\[?[A-Za-z_]", "the file contains TOML: give it a name that ends in .toml"),
    (r"(?://|#|/\*)", "remove comments"),
    (r",\s*[}\]]", "remove the comma before the bracket"),
    (r"'", "write keys and texts between double quotation marks"),
    (r":\s*[-+]?\d+,\d", "write numbers with a decimal point"),
    (r":\s*[-+]?\.\d", "write a digit before the decimal point"),
    (r":\s*(?:True|False|None)\b", "write true, false or null"),
)

#: Largest number of characters of a line that are compared with the patterns.
_LONGEST_LINE = 300


def other_content(data: bytes) -> str:
    """Return why a file of another kind cannot be read, with a remedy, or "" if its kind is unknown."""
    head = data[:200]
    return next((text for start, text in _OTHER_CONTENTS if re.match(start, head, re.IGNORECASE)), "")


def advice_on_line(text: str, message: str, ending: str) -> str:
    """Return advice on the line that an error message names, or "" if no mistake is recognised there.

    ``ending`` is ".toml" or ".json".
    """
    named = re.search(r"line (\d+)", message)
    lines = text.splitlines()
    number = int(named.group(1)) if named else len(lines)
    patterns = _TOML_ADVICE if ending == ".toml" else _JSON_ADVICE
    if re.search("twice|overwrite", message):
        return "remove the repeated key or table, or write [[name]] for each table of a list"
    # Leave out texts between quotation marks, unless a backslash in them may be the mistake.
    quoted = r"\"[^\"\\]*\"|'[^']*'" if ending == ".toml" else r"\"[^\"\\]*\""
    # A parser may name the line after the mistake, for example after a comma at the end of a JSON list.
    for first in (number - 1, max(number - 2, 0)):
        line = re.sub(quoted, '""', " ".join(part[:_LONGEST_LINE] for part in lines[first:number]))
        for pattern, advice in patterns:
            if re.search(pattern, line):
                return advice
    return ""
