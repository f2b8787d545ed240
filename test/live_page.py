"""The command `dashboard` in a process of its own, and its page in a browser."""

import os
import signal
import subprocess
import sys
from pathlib import Path

from processes import wait_until

PLUGINS = Path(__file__).parent / 'plugins'


class LivePage:
    """
    A dashboard that has been started.

    Parameters
    ----------
    folder : Path
        Its output.
    arguments : sequence of str
        Of the command.
    environment : dict of str to str
        Variables of a ROS domain.

    """

    def __init__(self, folder, *arguments, environment=()):
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)
        self._errors = (folder / 'stderr.txt').open('wb')
        self.process = subprocess.Popen(
            [sys.executable, '-m', 'mobile_robot_control.cli.dashboard', '--port', '0', '--output', str(folder),
             *arguments], stdout=subprocess.PIPE, stderr=self._errors, text=True, env=os.environ | dict(environment))
        line = self.process.stdout.readline()
        assert line.startswith('dashboard: http://'), (line, self.process.wait(60))
        self.address = line.split()[1]

    def printed(self):
        """Return what it has printed on its standard error."""
        return (self.folder / 'stderr.txt').read_text(encoding='utf-8')

    @property
    def port(self):
        """Of the page."""
        return int(self.address.split(':')[2].split('/')[0])

    def nodes(self):
        """Return the process numbers of the nodes that it has started."""
        children = Path(f'/proc/{self.process.pid}/task/{self.process.pid}/children').read_text().split()
        return [int(child) for child in children
                if b'ros.executables' in Path(f'/proc/{child}/cmdline').read_bytes()]

    def stop(self):
        """End it as Ctrl-C does; return its exit code."""
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(60)

    def close(self):
        """End it, whatever its state."""
        if self.process.poll() is None:
            self.stop()
        self.process.stdout.close()
        self._errors.close()


class OpenPage:
    """The page in a browser of selenium, as a user finds it."""

    def __init__(self, browser, address):
        self.browser, self.driver = browser, browser.driver
        self.driver.get(address)
        self.wait(lambda: self.text('run').startswith('t = ') and self.text('nodes').count('running') == 4
                  and self.driver.execute_script('return document.getElementById("law").options.length'))

    def wait(self, condition, seconds=60.0):
        """Wait until a condition holds in the page."""
        try:
            wait_until(condition, seconds, 0.05)
        except AssertionError as error:
            shown = [self.text(name) for name in ('run', 'nodes', 'notice', 'changes')]
            raise AssertionError(f'{error}; the page shows {shown}') from None

    def find(self, selector):
        """Return the only element of a CSS selector."""
        found, = self.driver.find_elements('css selector', selector)
        return found

    def text(self, name):
        """Return the text of the element of a name."""
        return self.driver.execute_script(f'return (document.getElementById("{name}") || {{}}).textContent || ""')

    def number(self, column):
        """Return the newest number of a column."""
        return self.driver.execute_script(
            f'const row = mrc.stage && mrc.stage.newest(); return row ? mrc.live.column("{column}")(row) : null')

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
        """Return the words of the refusal under a parameter."""
        return self.parameter(name).find_element('css selector', '.words').text

    def keys(self, text):
        """Type keys that are for no field."""
        from selenium.webdriver.common.action_chains import ActionChains

        self.driver.execute_script('if (document.activeElement) document.activeElement.blur()')
        ActionChains(self.driver).send_keys(text).perform()

    def type_into(self, field, text):
        """Replace what a field holds, as a user does."""
        from selenium.webdriver.common.keys import Keys

        field.send_keys(Keys.CONTROL, 'a')
        field.send_keys(Keys.NULL, text, Keys.ENTER)

    def choose(self, name, value):
        """Choose a value of a list."""
        from selenium.webdriver.support.select import Select

        Select(self.find(f'#{name}')).select_by_value(value)


class Lesson:
    """
    A lesson of the page, opened.

    Parameters
    ----------
    page : OpenPage
    title : str
        A part of its title.

    """

    def __init__(self, page, title):
        self._page = page
        self.element, = [found for found in page.driver.find_elements('css selector', '#lessons details')
                         if title in found.find_element('css selector', 'summary').text]
        page.driver.execute_script('arguments[0].open = true; arguments[0].scrollIntoView()', self.element)

    def move(self, number, value):
        """Set a control."""
        self._page.driver.execute_script(
            'const field = arguments[0].querySelectorAll(".controls input, .controls select")[arguments[1]];'
            'field.value = arguments[2]; field.dispatchEvent(new Event("change"))', self.element, number, value)

    def verdict(self):
        """Return what is said of the last answer or of a control."""
        return self.element.find_element('css selector', '.verdict').text

    def check(self, answer=''):
        """Answer, and return what is said of it."""
        if answer:
            self._page.driver.execute_script(
                'arguments[0].querySelector(".bar input, .bar select").value = arguments[1]', self.element, answer)
        button = self.element.find_element('css selector', '.bar button')
        self._page.driver.execute_script('arguments[0].click()', button)
        self._page.wait(button.is_enabled)
        return self.verdict()
