"""A headless Chromium, driven with selenium: one page, whose errors and requests are kept."""

import importlib.resources
import json
import os
import shutil

import pytest

CHROMIUM = shutil.which('chromium') or shutil.which('chromium-browser') or shutil.which('google-chrome')
DRIVER = shutil.which('chromedriver')
REQUIRED = 'REQUIRE_BROWSER'
"""Environment variable: where it is set, a test that finds no browser fails."""


def refuse_to_start(reason):
    """Skip the test for want of a browser, or fail where the environment requires one."""
    if os.environ.get(REQUIRED):
        pytest.fail(f'{reason}, and {REQUIRED} is set', pytrace=False)
    pytest.skip(reason)


class Browser:
    """One page; a context manager."""

    def __init__(self, profile):
        from selenium import webdriver

        options = webdriver.ChromeOptions()
        options.binary_location = CHROMIUM
        for argument in ('--headless', '--no-sandbox', '--disable-gpu', '--disable-dev-shm-usage', '--no-first-run',
                         '--disable-background-networking', '--disable-component-update', f'--user-data-dir={profile}'):
            options.add_argument(argument)
        options.set_capability('goog:loggingPrefs', {'browser': 'ALL', 'performance': 'ALL'})
        self.driver = webdriver.Chrome(options, webdriver.ChromeService(DRIVER))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.driver.quit()

    def call(self, method, **parameters):
        """Send a command of the DevTools protocol and return its result."""
        return self.driver.execute_cdp_cmd(method, parameters)

    def evaluate(self, expression):
        """Return the value of a JavaScript expression in the page; a promise is awaited."""
        return self.driver.execute_script(f'return ({expression})')

    def show(self, path, width, scheme='light', height=900, scripts=True):
        """Open a file in a window of a size, on light or dark ground, and wait until its pictures are there."""
        self.call('Emulation.setDeviceMetricsOverride', width=width, height=height, deviceScaleFactor=1,
                  mobile=width < 600)
        self.call('Emulation.setScriptExecutionDisabled', value=not scripts)
        self.media('', scheme)
        self.driver.get('about:blank')
        self.errors(), self.requests()
        self.driver.get(path.as_uri())
        self.evaluate('Promise.all([...document.images].map(image => image.decode().catch(() => 0)))')
        if scripts:
            # charts take the width that is left by then
            self.evaluate('new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done())))')

    def media(self, kind, scheme):
        """Show the page as on 'print' or, with '', as on a screen, on light or dark ground."""
        self.call('Emulation.setEmulatedMedia', media=kind,
                  features=[{'name': 'prefers-color-scheme', 'value': scheme}])

    def close_other_windows(self):
        """Close all windows but the first."""
        first, *others = self.driver.window_handles
        for window in others:
            self.driver.switch_to.window(window)
            self.driver.close()
        self.driver.switch_to.window(first)

    def violations(self):
        """Return what axe-core finds wrong in the page as it is, for screen readers and eyes: rule and elements."""
        pytest.importorskip('axe_core_python')
        script = (importlib.resources.files('axe_core_python') / 'axe.min.js').read_text(encoding='utf-8')
        # as a debugger does: the page's own policy forbids other scripts
        self.call('Runtime.evaluate', expression=script)
        found = self.driver.execute_async_script('axe.run(document).then(arguments[arguments.length - 1])')
        assert len(found['passes']) > 10
        return [(one['id'], [node['html'][:120] for node in one['nodes'][:3]]) for one in found['violations']]

    def errors(self):
        """Return what the console has logged since the last call."""
        return [entry['message'] for entry in self.driver.get_log('browser')]

    def requests(self):
        """
        Return the addresses that were asked for since the last call.

        Without those of data in the page itself, and those that the page's policy refused, which are errors.
        """
        events = [json.loads(entry['message'])['message'] for entry in self.driver.get_log('performance')]
        refused = {event['params']['requestId'] for event in events
                   if event['method'] == 'Network.loadingFailed' and event['params'].get('blockedReason') == 'csp'}
        asked = [event['params'] for event in events if event['method'] == 'Network.requestWillBeSent']
        return [one['request']['url'] for one in asked
                if not one['request']['url'].startswith('data:') and one['requestId'] not in refused]
