"""Advise how to correct a file that is not what its name says, or a line that is not valid TOML or JSON."""

import re

#: First bytes of files that cannot be read, such as web pages and archives, each with a reason and a remedy.
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
    (r"[\u00a0\u2000-\u200b\u202f\ufeff]", "replace the Unicode space by an ordinary space"),
    (r"^\s*\{\s*(?:[\"}]|$)", "the file contains JSON: give it a name that ends in .json"),
    (r"^\s*[\w-]+\s*:", "write '=' between key and value"),
    (r"=\s*[-+]?\d+,\d+\s*(?:#|$)", "write numbers with a decimal point"),
    (r"(?:[=\[,]\s*|[-+])\.\d", "write a digit before the decimal point"),
    (r"(?:[=\[,]\s*)[-+]?\d+\.\s*(?:[,\]#]|$)", "write a digit after the decimal point"),
    # The pattern fits a number with a unit, such as 1e5 N, but not 1e5 or 0x1F, whose letters are no unit.
    (
        r"=\s*[-+]?(?!0[xob])\d[\d.]*(?:[eE][-+]?\d+\s*|\s*(?![eE][-+]?\d))[^\W\d_]",
        "write numbers without a unit",
    ),
    (r"=\s*(?:True|False|TRUE|FALSE|[Yy]es|[Nn]o)\b", "write true or false"),
    (r"\"[^\"]*\\", "write paths with '/', or between single quotation marks"),
    (r"=\s*(?!(?:true|false|inf|nan)\b)[^\W\d_]", "write text between quotation marks"),
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
    """Return a reason and a remedy if the file is, for example, a web page or an archive; otherwise ""."""
    head = data[:200]
    return next((text for start, text in _OTHER_CONTENTS if re.match(start, head, re.IGNORECASE)), "")


def advice_on_line(text: str, message: str, ending: str) -> str:
    """Return advice on the line that an error message names, or "" if the line has no known mistake.

    ``ending`` is ".toml" or ".json".
    """
    line_number = re.search(r"line (\d+)", message)
    lines = text.splitlines()
    number = int(line_number.group(1)) if line_number else len(lines)
    patterns = _TOML_ADVICE if ending == ".toml" else _JSON_ADVICE
    if re.search("twice|overwrite", message):
        return "remove the repeated key or table, or write [[name]] for each table of a list"
    # A parser of JSON may name the line after the mistake, for example after a comma at the end of a list. A
    # parser of TOML names the line of the mistake, so the line before it is correct.
    earliest_line = number - 1 if ending == ".toml" else number - 2
    for first in range(number - 1, max(earliest_line, 0) - 1, -1):
        line = "\n".join(_replace_texts(part[:_LONGEST_LINE], ending) for part in lines[first:number])
        for pattern, advice in patterns:
            if re.search(pattern, line):
                return advice
    return ""


def _replace_texts(line: str, ending: str) -> str:
    """Return a line in which "" replaces each quoted text. In TOML, also remove the comment.

    A text with a backslash remains, because the backslash may be the mistake.
    """
    if ending == ".json":
        return re.sub(r"\"[^\"\\]*\"", '""', line)
    without_texts = re.sub(r"\"[^\"\\]*\"|'[^']*'", '""', line)
    return re.sub(r"#.*", "", without_texts)
