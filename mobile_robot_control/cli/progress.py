"""Progress bars, whatever the environment variables of tqdm are."""

import os
import sys

try:
    from tqdm import tqdm
except ValueError as error:
    # tqdm reads TQDM_MININTERVAL and the like while it is imported, and that fails where one is no number
    odd = {name: os.environ.pop(name) for name in sorted(os.environ) if name.startswith('TQDM_')}
    print(f'not used: {", ".join(f"{name}={value!a}" for name, value in odd.items())} ({error})', file=sys.stderr)
    from tqdm import tqdm

__all__ = ['tqdm']
