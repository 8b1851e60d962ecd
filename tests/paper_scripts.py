"""The paper's examples, as scripts of the guide's gallery."""

from types import SimpleNamespace

from masonry_opt.studies.reproduce import scripts

SCRIPTS = scripts()


def definitions(name: str) -> SimpleNamespace:
    """What a script defines before it solves: functions, constants and scenes."""
    names: dict[str, object] = {"__name__": name}
    exec(SCRIPTS[name].read_text("utf-8").split("\n# %%\n")[0], names)
    return SimpleNamespace(**names)
