"""HTML pages from the templates of this folder; all values are escaped."""

from __future__ import annotations

from masonry_opt.errors import OptionError
from masonry_opt.files import WRITER

#: Message where a library for charts or pages is missing.
NEEDED = "charts and pages need Altair, vl-convert and Jinja2; install them with: pip install '.[studies]'"


def render(template: str, **values: object) -> str:
    """A page from a template in ``templates/`` and the values it names.

    Raises OptionError if Jinja2, of the extra "studies", is not installed.
    """
    try:
        import jinja2
    except ImportError:
        raise OptionError(NEEDED) from None
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("masonry_opt.studies"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render(writer=WRITER, **values)
