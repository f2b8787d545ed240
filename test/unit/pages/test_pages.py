"""The page of a report holds all that it shows, and beside it stand the figures as files."""

import re

from measuring import configuration

from mobile_robot_control.pages import report_writing
from mobile_robot_control.runs.run import Run
from mobile_robot_control.runs.samples import collect
from mobile_robot_control.simulation.rollout import rollout


def test_the_page_loads_nothing_from_elsewhere(tmp_path):
    parameters = configuration()
    run = Run('run', collect(rollout(parameters, 0.1)), (), {'duration': 0.1}, parameters)
    written = report_writing.write_report([run], tmp_path, lambda _: None)
    text = written.read_text(encoding='utf-8')
    assert text.count('src="data:image/svg+xml,') == len(report_writing.RUN_FIGURES)
    assert not re.search(r'(src|href)="(?!data:|#)', text)
    assert '@import' not in text
    for figure in report_writing.RUN_FIGURES:
        stem = tmp_path / 'figures' / figure.name
        assert stem.with_suffix('.png').read_bytes().startswith(b'\x89PNG')
        assert '<svg' in stem.with_suffix('.svg').read_text(encoding='utf-8')
