"""Configuration of Sphinx, which builds the guide (``make guide``) without a network connection."""

import logging
import sys
from importlib.metadata import version as installed_version
from pathlib import Path

HERE = Path(__file__).parent
# Sphinx must import the guide's own extensions, and masonry_opt from this clone for the reference.
sys.path[:0] = [str(HERE / "_ext"), str(HERE.parent)]

project = "masonry_opt"
author = copyright = "The masonry_opt authors"
release = version = installed_version("masonry_opt")

# These libraries, which the examples use, log many messages that do not concern the build.
for library in ("ezdxf", "pyomo", "traitlets"):
    logging.getLogger(library).setLevel(logging.WARNING)

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
    "mathml",
    "records",
    "short_code",
]
exclude_patterns = ["gallery", "examples/**/*.ipynb", "examples/**/*.py"]
source_suffix = {".rst": "restructuredtext", ".md": "myst-nb", ".ipynb": "myst-nb"}

# The build fails if a page refers to a function or class that the reference does not describe.
nitpicky = True
nitpick_ignore = [("py:exc", "KeyboardInterrupt"), ("py:exc", "OSError")]

# The pages are Markdown with mathematics. Pages may link to headings.
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
html_math_renderer = "mathml"

# The notebook is stored without outputs, and is run when the guide is built.
nb_execution_mode = "force"
nb_execution_timeout = 120
nb_execution_raise_on_error = True
# Output of a cell on standard error is removed from the page, and the warning makes the build fail.
nb_output_stderr = "remove-warn"

# Options of the reference, which is made from docstrings.
autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False
# Parameters that share a description stay together, so that the description is shown once.
napoleon_use_param = False
# One entry may describe several names. Napoleon supports it only for sections in the style of parameters.
napoleon_custom_sections = [("Attributes", "params_style"), ("Fields", "params_style")]

sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "examples",
    # The guide runs an example of the paper only if the example takes seconds.
    "filename_pattern": r"gallery/(?!paper)\w+/\w+\.py$|paper/fig(7|8|10|12)\.py$",
    "ignore_pattern": r"__init__",
    "subsection_order": [
        "gallery/first",
        "gallery/arches",
        "gallery/walls",
        "gallery/loads",
        "gallery/space",
        "gallery/many",
        "gallery/methods",
        "gallery/paper",
    ],
    "within_subsection_order": "FileNameSortKey",
    "image_scrapers": ("figures.scraper",),
    "ignore_repr_types": r"matplotlib|Picture|altair",
    "default_thumb_file": str(HERE / "no_picture.png"),
    "abort_on_example_error": True,
    "download_all_examples": False,
    "write_computation_times": False,
    "show_memory": False,
    "show_signature": False,
    "remove_config_comments": True,
}

# Options of the appearance.
html_theme = "furo"
html_title = f"masonry_opt {release}"
html_static_path = ["_static"]
html_css_files = ["guide.css"]
html_copy_source = False
html_show_sphinx = False
