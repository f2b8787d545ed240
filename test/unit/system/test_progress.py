"""Progress bars: a widget in a kernel of Jupyter that has widgets, a line of text elsewhere; names of waits."""

import importlib
import importlib.util
import io
import sys
from types import ModuleType

from mobile_robot_control.system import progress
from mobile_robot_control.system.progress import StagedBar


def test_a_bar_is_a_widget_in_a_kernel_with_widgets_alone(monkeypatch):
    installed = []
    monkeypatch.delitem(sys.modules, 'ipykernel', raising=False)
    monkeypatch.setattr(importlib.util, 'find_spec', lambda name: name if name in installed else None)

    def kind():
        return importlib.reload(progress).tqdm.__module__

    assert kind() == 'tqdm.std'
    with monkeypatch.context() as kernel:
        kernel.setitem(sys.modules, 'ipykernel', ModuleType('ipykernel'))
        assert kind() == 'tqdm.std'
        installed.append('ipywidgets')
        assert kind() == 'tqdm.notebook'
    assert kind() == 'tqdm.std'


def test_a_bar_says_what_is_done_before_its_first_update_and_after_its_last():
    shown = io.StringIO()
    with StagedBar(2, 'run', 'driving', True, file=shown, mininterval=0.0) as bar:
        assert 'compiling:   0%' in shown.getvalue()
        bar.update()
        assert 'driving:  50%' in shown.getvalue()
        bar.update()
    assert shown.getvalue().splitlines()[-1].startswith('analysing and drawing: 100%')
