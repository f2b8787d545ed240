"""The page open for long: memory stays flat in nodes, page process and browser tab."""

import os
import statistics
import time
from pathlib import Path

import pytest
from live_page import LivePage, OpenPage

SOAK = float(os.environ.get('SOAK_SECONDS', '3600'))
WARM = min(120.0, 0.25 * SOAK)
LARGEST = 1.1
"""Of the memory at the end to that when all was warm."""
MORE = 8.0
"""[MB] that any of them may have more."""


def _megabytes(pid):
    """Return the resident memory of a process [MB]."""
    for line in Path(f'/proc/{pid}/status').read_text().splitlines():
        if line.startswith('VmRSS'):
            return int(line.split()[1]) / 1024
    raise AssertionError(f'{pid} has ended')


def _of_tab(page):
    """Return the memory of the page's scripts after a collection [MB]."""
    page.browser.call('HeapProfiler.collectGarbage')
    return page.browser.call('Runtime.getHeapUsage')['usedSize'] / 1e6


@pytest.mark.soak
@pytest.mark.timeout(SOAK + 300)
def test_an_open_page_does_not_grow(domain, browser, tmp_path):
    live = LivePage(tmp_path)
    try:
        page = OpenPage(browser, live.address)
        pids = {f'node {pid}': pid for pid in live.nodes()} | {'page': live.process.pid}
        begun, found = time.monotonic(), {name: [] for name in [*pids, 'tab']}
        while time.monotonic() < begun + SOAK:
            time.sleep(min(10.0, SOAK / 40))
            if time.monotonic() > begun + WARM:
                for name, pid in pids.items():
                    found[name].append(_megabytes(pid))
                found['tab'].append(_of_tab(page))
                # what the driver keeps of each request and line
                assert not browser.errors()
                browser.requests()
        for name, megabytes in found.items():
            fifth = max(1, len(megabytes) // 5)
            early, late = statistics.median(megabytes[:fifth]), statistics.median(megabytes[-fifth:])
            print(f'{name}: {early:.1f} MB, then {late:.1f} MB')
            assert late < max(LARGEST * early, early + MORE), name
        reached = page.number('time')
        page.wait(lambda: page.number('time') > reached)
    finally:
        browser.driver.get('about:blank')
        live.close()
