"""Progress bars: a widget in a kernel of Jupyter that has widgets, a line of text elsewhere."""

import importlib
import importlib.util
import sys
from types import ModuleType

from mobile_robot_control.system import progress


def test_a_bar_is_a_widget_in_a_kernel_with_widgets_alone(monkeypatch):
    installed = []
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
