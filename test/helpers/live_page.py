"""The command `dashboard` in a process of its own, and its page in a browser."""

import contextlib
import os
import signal
import subprocess
import sys
from pathlib import Path

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.select import Select

from helpers.processes import wait_until

PLUGINS = Path(__file__).parents[1] / 'plugins'


def megabytes(pid):
    """Return the resident memory of a process [MB]."""
    return int(Path(f'/proc/{pid}/status').read_text().partition('VmRSS:')[2].split()[0]) / 1024


class LivePage:
    """A dashboard that has been started, with its output folder, arguments and the variables of a ROS domain."""

    def __init__(self, folder, *arguments, environment=()):
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)
        self._command = [sys.executable, '-m', 'mobile_robot_control.dashboard.command', '--port', '0', '--output',
                         str(folder), *arguments]
        self._environment = os.environ | dict(environment)
        self.start()

    def start(self):
        self._errors = (self.folder / 'stderr.txt').open('wb')
        self.process = subprocess.Popen(self._command, stdout=subprocess.PIPE, stderr=self._errors, text=True,
                                        env=self._environment)
        line = self.process.stdout.readline()
        assert line.startswith('dashboard: http://'), (line, self.process.wait(60))
        self.address = line.split()[1]

    def printed(self):
        return (self.folder / 'stderr.txt').read_text(encoding='utf-8')

    def nodes(self):
        """Return the process numbers of the nodes that it has started."""
        found = []
        for process in Path('/proc').glob('[0-9]*'):
            with contextlib.suppress(OSError):  # it has ended meanwhile
                parent = (process / 'stat').read_text().rpartition(')')[2].split()[1]
                if int(parent) == self.process.pid and b'ros.start.executables' in (process / 'cmdline').read_bytes():
                    found.append(int(process.name))
        return found

    def stop(self):
        """End it as Ctrl-C does; return its exit code."""
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(60)

    def close(self):
        if self.process.poll() is None:
            self.stop()
        self.process.stdout.close()
        self._errors.close()


class OpenPage:
    """The page in a browser of selenium, as a user finds it."""

    def __init__(self, browser, address, nodes=4):
        self.browser, self.driver = browser, browser.driver
        self.driver.get(address)
        # a node that answers later makes its controls anew
        known = ('return [...document.querySelectorAll("#parameters [data-role]")]'
                 '.filter((one) => one.querySelector("[data-parameter]")).length')
        self.wait(lambda: self.text('run').startswith('t = ') and self.text('nodes').count('running') >= (nodes or 3)
                  and self.driver.execute_script(known) >= (nodes or 3))

    def wait(self, condition, look=lambda: None):
        """Wait until a condition holds in the page; a failure tells what `look` returns."""
        try:
            wait_until(condition, 60.0, 0.05)
        except AssertionError as error:
            shown = [look(), *(self.text(name) for name in ('run', 'nodes', 'notice', 'changes', 'recorded'))]
            raise AssertionError(f'{error}; the page shows {shown}') from None

    def find(self, selector):
        found, = self.driver.find_elements('css selector', selector)
        return found

    def text(self, name):
        return self.driver.execute_script(f'return (document.getElementById("{name}") || {{}}).textContent || ""')

    def number(self, column):
        """Return the newest number of a column, once there is one: a topic that was silent for a second has none."""
        found = []

        def is_there():
            found.append(self.driver.execute_script(
                f'const row = mrc.stage && mrc.stage.newest(); return row ? mrc.live.column("{column}")(row) : null'))
            return found[-1] is not None

        self.wait(is_there)
        return found[-1]

    def settle(self):
        self.wait(lambda: self.driver.execute_script('return !(window.mrc && mrc.live) || mrc.live.idle()'))

    def hold(self):
        """Hold the run, and wait until the page shows it."""
        self.keys(' ')
        self.wait(lambda: self.find('#step').is_enabled())
        self.settle()

    def click(self, element):
        """Click an element once it can be seen."""
        self.wait(element.is_displayed)
        element.click()

    def parameter(self, name, node='position_controller'):
        """Return the element of a parameter, its group opened."""
        row = self.find(f'details[data-group^="{node}/"] [data-parameter="{name}"]')
        self.driver.execute_script('arguments[0].closest("details").open = true; '
                                   'arguments[0].scrollIntoView({block: "center"})', row)
        return row

    def words(self, name):
        return self.parameter(name).find_element('css selector', '.words').text

    def keys(self, text):
        """Type keys that are for no field."""
        self.driver.execute_script('if (document.activeElement) document.activeElement.blur()')
        self.keys_here(text)

    def keys_here(self, *keys):
        ActionChains(self.driver).send_keys(*keys).perform()

    def type_into(self, field, text):
        """Replace what a field holds, as a user does."""
        field.send_keys(Keys.CONTROL, 'a')
        field.send_keys(Keys.NULL, text, Keys.ENTER)

    def choose(self, name, value):
        Select(self.find(f'#{name}')).select_by_value(value)


class Lesson:
    """A lesson of the page, begun by keyboard alone; the name of its file begins with its number."""

    def __init__(self, page, name):
        self._page = page
        self._state('lesson')  # it listens from now on: a state is told when it changes
        if not page.driver.execute_script('return document.querySelector("#live.teaching")'):
            self.focus('#lessons')
            self._page.keys_here(Keys.ENTER)
            page.wait(lambda: page.driver.find_elements('css selector', '#lesson select'))
        self.focus('#lesson .head select')
        self._page.keys_here(name[0])
        page.wait(lambda: page.driver.execute_script('return location.hash') == f'#lesson={name}')
        page.wait(lambda: self._state('lesson') == name)

    def _state(self, name):
        """Return what the server has told last."""
        self._page.driver.execute_script(
            'if (!window.told) { window.told = {}; mrc.live.on("state", (state) => { window.told = state; }); }')
        return self._page.driver.execute_script('return window.told[arguments[0]]', name)

    def focus(self, selector):
        """Move the focus to an element by the tabulator."""
        found = 'return document.activeElement && document.activeElement.matches(arguments[0])'
        for _ in range(80):
            if self._page.driver.execute_script(found, selector):
                return
            self._page.keys_here(Keys.TAB)
        raise AssertionError(f'{selector} cannot be reached by keyboard')

    def move(self, number, *keys):
        self.focus(f'#lesson .controls label:nth-child({number + 1}) :is(input, select)')
        self._page.keys_here(*keys)

    def verdict(self):
        """Return what is said of the last answer or of a control."""
        return self._page.find('#lesson .verdict').text

    def check(self, *keys):
        """Answer by keys, and return what is said of it."""
        if keys:
            self.focus('#lesson form :is(input, select)')
            if self._page.driver.execute_script('return document.activeElement.tagName') == 'INPUT':
                self._page.driver.execute_script('document.activeElement.value = ""')
            self._page.keys_here(*keys)
        self.focus('#lesson form button')
        # it answers after the requests of controls
        self._page.driver.execute_script('document.querySelector("#lesson .verdict").textContent = ""')
        self._page.keys_here(Keys.ENTER)
        self._page.wait(self.verdict)
        return self.verdict()

    def hidden(self):
        """Return what the lesson needs and is not in view, without scrolling."""
        return self._page.driver.execute_script(
            'const needed = ["#scene", "#numbers", "#lesson .controls", "#lesson .question", "#lesson form"];'
            'if (!document.querySelector("#charts").hidden) needed.push("#charts figure:not([hidden])");'
            'return needed.filter((name) => { const box = document.querySelector(name).getBoundingClientRect();'
            'return box.top < 0 || box.bottom > window.innerHeight + 1 || box.right > window.innerWidth + 1; })')

    def close(self):
        """Leave the lesson, and wait until what it changed is taken back."""
        self.focus('#lesson .head button')
        self._page.keys_here(Keys.ENTER)
        self._page.wait(lambda: self._state('lesson') == '')
