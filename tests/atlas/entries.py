"""The failure atlas: small scenes, each built so that a named method fails, and what every method and
solver must answer. Adding a failure is one entry in one of its parts."""

from atlas import scene_failures, solver_failures
from atlas.entry import Entry

ATLAS: tuple[Entry, ...] = (*solver_failures.ENTRIES, *scene_failures.ENTRIES)
