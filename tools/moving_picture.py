"""The moving picture of README.md: a headless Chromium plays the replay of a report."""

import io
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

import mobile_robot_control as mrc
from mobile_robot_control.pages import page
from mobile_robot_control.pages.page_parts import first_screen, replay_scripts, replay_styles
from mobile_robot_control.report.animation import write_frames

_WINDOW = (720, 620)
"""[px]: the replay fills what sentence and numbers leave."""
FRAMES, _COLORS = 96, 64
LAP = 16.0
"""[s]."""
_BESIDE = (0.7, -0.4, 0.0)
"""Start of the robot, 0.5 m from the cart [m], [m], [rad]."""


def _chromium() -> Any:
    """Start a headless Chromium; SystemExit with the remedy where there is none."""
    try:
        from selenium import webdriver  # noqa: PLC0415 (of the extra `test`; nothing else of the package needs it)
    except ImportError:
        sys.exit("selenium is not installed; install the extra 'test'")
    binary, driver = (shutil.which(name) for name in ('chromium', 'chromedriver'))
    if binary is None or driver is None:
        sys.exit('chromium or chromedriver is not in the PATH; install chromium and chromium-driver')
    options = webdriver.ChromeOptions()
    options.binary_location = binary
    for argument in ('--headless', '--no-sandbox', '--disable-gpu', '--disable-dev-shm-usage', '--hide-scrollbars',
                     f'--window-size={_WINDOW[0]},{_WINDOW[1]}'):
        options.add_argument(argument)
    return webdriver.Chrome(options, webdriver.ChromeService(driver))


def _frames(driver: Any, file: Path) -> Iterator[Image.Image]:
    """Yield pictures of the replay on a page, evenly over the run."""
    driver.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', {
        'width': _WINDOW[0], 'height': _WINDOW[1], 'deviceScaleFactor': 1, 'mobile': False})
    driver.get(file.as_uri())
    end = driver.execute_script('return mrc.clock.end')
    # without the buttons, on which nobody can click here
    element = driver.find_element('css selector', '#replay canvas')
    for time in np.linspace(0.0, end, FRAMES):
        driver.execute_script('mrc.clock.set(arguments[0])', float(time))
        yield Image.open(io.BytesIO(element.screenshot_as_png)).convert('RGB')


def write_moving_picture(config: Path, file: Path) -> None:
    """
    Play a lap of the lemniscate as a report shows it, and write it as an animation.

    Parameters
    ----------
    config : Path
        Folder of the configurations.
    file : Path
        GIF.

    Raises
    ------
    SystemExit
        Where there is no Chromium; the file is left as it is.
    """
    # the first law of the table in README.md
    run = mrc.simulate(config / 'kanayama.yaml', duration=LAP, name="Kanayama's law", parameters={
        'reference_cart.curve': 'lemniscate', 'reference_cart.period': LAP, 'plant.initial_pose': _BESIDE})
    driver = _chromium()
    try:
        with tempfile.TemporaryDirectory() as folder:
            shown = Path(os.path.realpath(folder)) / 'report.html'
            shown.write_text(page.page('replay', [first_screen('replay', [run])], replay_styles(), replay_scripts()),
                             encoding='utf-8')
            write_frames(list(_frames(driver, shown)), file, _COLORS)
    finally:
        driver.quit()


if __name__ == '__main__':
    write_moving_picture(Path('config'), Path(sys.argv[1]))
