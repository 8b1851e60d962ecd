"""Commands of the package, each in a process of its own. The processes import slow modules only once."""

import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

#: Program that imports modules once, and then runs each command in a fork. The standard output and the
#: standard error of a command are written to files with the name of the command.
_PROGRAM = """
import gc, json, os, sys
from importlib import import_module

folder, modules, commands = json.loads(sys.argv[1])
for module in modules:
    import_module(module)
from masonry_opt.cli import main
{before}
if not sys.flags.dev_mode:
    # Without this call, each fork would write to the memory of all modules, and copy it. In development mode,
    # Python reports files that are left open, but it would not report a file to which a frozen class refers.
    gc.freeze()
codes = {{}}
for name, arguments in commands.items():
    process = os.fork()
    if process == 0:
        for stream in (1, 2):
            os.dup2(os.open(f"{{folder}}/{{name}}.{{stream}}", os.O_WRONLY | os.O_CREAT), stream)
        sys.argv = ["masonry-opt", *arguments]
        sys.exit(main())
    codes[name] = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
print(json.dumps(codes))
"""


def in_forks(
    commands: Mapping[str, Sequence[object]],
    folder: Path,
    modules: Sequence[str],
    *,
    options: Sequence[str] = (),
    before: str = "",
) -> dict[str, tuple[int, str, str]]:
    """Run commands, and return the exit code, standard output and standard error of each.

    Parameters
    ----------
    commands
        The arguments of each command, by name.
    folder
        Folder of the files with the outputs.
    modules
        Modules that are imported before the commands run.
    options
        Options of Python.
    before
        Lines of Python that run before the commands. The name of the command that runs is in ``name``.
    """
    words = {name: [str(argument) for argument in arguments] for name, arguments in commands.items()}
    inputs = json.dumps([str(folder), list(modules), words])
    program = [sys.executable, *options, "-c", _PROGRAM.format(before=before), inputs]
    ran = subprocess.run(program, capture_output=True, text=True, check=False)
    assert (ran.returncode, ran.stderr) == (0, "")
    return {
        name: (code, *((folder / f"{name}.{stream}").read_text() for stream in (1, 2)))
        for name, code in json.loads(ran.stdout).items()
    }
