"""The folder of an experiment is as it was where a run is refused, even an experiment that was to be replaced."""

import pytest

from mobile_robot_control.configuration.nodes import Configuration
from mobile_robot_control.experiment.folders import experiment_folders
from mobile_robot_control.parameters.checking import ParameterError


@pytest.fixture
def held(tmp_path):
    """A folder with an experiment, and a file of the user's."""
    output = tmp_path / 'run'
    (output / 'bag').mkdir(parents=True)
    (output / 'bag' / 'run.mcap').write_text('old')
    (output / 'metrics.json').write_text('old')
    (output / 'notes.txt').write_text('mine')
    return output


def _content(folder):
    return {str(path.relative_to(folder)): path.read_text() for path in folder.rglob('*') if path.is_file()}


@pytest.mark.parametrize('error', [ParameterError(['refused']), OSError(28, 'full')])
def test_a_run_that_is_refused_after_its_start_keeps_the_one_before(held, error):
    before = _content(held)

    def refused():
        with experiment_folders({held: Configuration()}, overwrite=True):
            (held / 'metrics.json').write_text('new')
            raise error

    with pytest.raises(type(error)):
        refused()
    assert _content(held) == before


def test_a_run_replaces_the_one_before(held):
    with experiment_folders({held: Configuration()}, overwrite=True) as unused:
        (held / 'metrics.json').write_text('new')
        unused.remove(held)
    assert _content(held).keys() == {'metrics.json', 'notes.txt', 'parameters.yaml'}
    assert (held / 'metrics.json').read_text() == 'new'


def test_a_second_run_that_is_refused_takes_nothing_from_the_first(held, tmp_path):
    other = tmp_path / 'other'

    def refused():
        with experiment_folders({held: Configuration(), other: Configuration()}, overwrite=True) as unused:
            (held / 'metrics.json').write_text('new')
            unused.remove(held)
            raise ParameterError(['refused'])

    with pytest.raises(ParameterError):
        refused()
    assert _content(held).keys() == {'metrics.json', 'notes.txt', 'parameters.yaml'}
    assert not other.exists()


def test_what_a_killed_run_has_left_is_removed(held):
    (held / '.replaced').mkdir()
    (held / '.replaced' / 'bag').write_text('older')
    with experiment_folders({held: Configuration()}, overwrite=True):
        pass
    assert not (held / '.replaced').exists()
