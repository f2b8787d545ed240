"""
The generated parts of docs/, as one table: what makes each, and which files it writes.

``python tools/pages.py`` makes all, ``python tools/pages.py docs/robots.md`` the parts of a file alone.
"""

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]


class Part(NamedTuple):
    """
    A generated part.

    Attributes
    ----------
    made_by : str
        A script, or a module of the package.
    files : tuple of str
        The files that it writes.
    arguments : tuple of str or None
        Of the script; `files` if None.

    """

    made_by: str
    files: tuple[str, ...]
    arguments: tuple[str, ...] | None = None


def parts() -> list[Part]:
    """Return the parts in the order in which they are made."""
    nodes = sorted(path.relative_to(ROOT).as_posix() for path in (ROOT / 'docs' / 'nodes').glob('*.md'))
    return [
        Part('tools/typed_names.py', ('mobile_robot_control/__init__.pyi',), ()),
        Part('tools/package_drawing.py', ('docs/images/packages.svg',), ()),
        Part('tools/parameter_table.py', ('docs/parameters.md', *nodes)),
        Part('tools/topic_tables.py', ('docs/topics.md', *nodes)),
        Part('tools/command_pages.py', ('docs/commands.md',)),
        Part('tools/metric_tables.py', ('docs/metrics.md',)),
        Part('tools/robots_table.py', ('docs/robots.md',)),
        Part('tools/robot_results.py', ('docs/robots.md',)),
        Part('mobile_robot_control.settings.sros2_policy', ('config/sros2/policy.xml',)),
        Part('tools/claims_table.py', ('docs/results.md',)),
        # six hours where the tracks or searches behind it have changed; it can be interrupted
        Part('tools/benchmark_results.py', ('docs/results.md', 'README.md', 'docs/images/benchmark_laws.png')),
        # an hour and a half, likewise
        Part('tools/velocity_law_results.py', ('docs/results.md',)),
        Part('tools/path_results.py', ('docs/results.md',)),
        Part('tools/result_pictures.py', ('docs/images/results_lemniscate.png', 'docs/images/results_trifolium.png',
                                          'docs/images/starts_map.png', 'docs/images/parking.png'), ('docs/images',)),
        Part('examples/tutorial/execute.py', ('examples/tutorial/trajectory_tracking.ipynb',), ()),
        # needs chromium
        Part('tools/moving_picture.py', ('docs/images/lemniscate.gif',)),
    ]


def main(wanted: Sequence[str] = ()) -> int:
    """Make the parts of some files, or of all; return the exit code of the first script that fails, or 0."""
    chosen = [part for part in parts() if not wanted or {*wanted} & {*part.files}]
    if not chosen:
        files = sorted({file for part in parts() for file in part.files})
        print(f'pages: no part is made for {", ".join(wanted)}; name some of {", ".join(files)}', file=sys.stderr)
        return 2
    path = os.pathsep.join([str(ROOT / 'examples' / 'chapter'), *filter(None, [os.environ.get('PYTHONPATH')])])
    for number, part in enumerate(chosen, start=1):
        print(f'{number} of {len(chosen)}: {part.made_by} {" ".join(part.files)}', flush=True)
        script = [part.made_by] if part.made_by.endswith('.py') else ['-m', part.made_by]
        arguments = part.files if part.arguments is None else part.arguments
        done = subprocess.run([sys.executable, *script, *arguments], cwd=ROOT, check=False,  # noqa: S603 (ours)
                              env={**os.environ, 'PYTHONPATH': path})
        if done.returncode:
            return done.returncode
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
