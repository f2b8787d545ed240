"""
Print one table: `python -m bench`, or `python -m bench lockstep memory` for some of it.

Every module `bench_*.py` beside this file offers `rows()`, an iterable of Row.
"""

import importlib
import os
import sys
from pathlib import Path

from bench.progress import show
from bench.row import Row, table


def modules(names: list[str]) -> list[str]:
    """List the modules of the named benchmarks, or of all."""
    found = sorted(path.stem for path in Path(__file__).parent.glob('bench_*.py'))
    unknown = {f'bench_{name}' for name in names} - set(found)
    if unknown:
        print(f'no such benchmark; there are {", ".join(name.removeprefix("bench_") for name in found)}',
              file=sys.stderr)
        sys.exit(2)
    return [name for name in found if not names or name.removeprefix('bench_') in names]


def main(names: list[str]) -> int:
    """
    Measure, and print what has been measured, also after Ctrl-C or an error.

    Returns 0 if all targets are met, 1 if not, 2 for an unknown name, 130 after Ctrl-C.
    """
    rows: list[Row] = []
    try:
        for name in modules(names):
            show(f'{name.removeprefix("bench_")} at a load of {os.getloadavg()[0]:.1f}')
            for row in importlib.import_module(f'bench.{name}').rows():
                rows.append(row)
                show(f'{row.name}: {row.ratio:.2f}')
    except KeyboardInterrupt:
        show('interrupted')
        return 130
    finally:
        show('')
        if rows:
            print(table(rows))
    return int(not all(row.holds for row in rows))


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
