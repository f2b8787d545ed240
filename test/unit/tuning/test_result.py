"""The parameter file that a search writes."""

import yaml

from mobile_robot_control.configuration.configure import configure
from mobile_robot_control.configuration.files import load
from mobile_robot_control.configuration.nodes import Configuration
from mobile_robot_control.tuning.result import parameter_file


def test_a_file_of_default_values_loads_and_has_no_empty_section(tmp_path):
    file = tmp_path / 'gains.yaml'
    file.write_text(parameter_file(Configuration(), {}, ['found by hand', '']))
    assert file.read_text().startswith('# found by hand\n#\n')
    assert configure(load([file])) == Configuration()
    assert '/**/plant' not in yaml.safe_load(file.read_text())


def test_what_differs_is_written_as_it_is_and_notes_with_line_breaks_stay_comments(tmp_path):
    file = tmp_path / 'gains.yaml'
    shared = Configuration().plant.shared._replace(odom_frame_id='y', base_frame_id='1_0')
    plant = Configuration().plant._replace(initial_pose=(2.0, 0.0, 0.0))
    made = Configuration(plant=plant)
    made = made._replace(**{node: group._replace(shared=shared) for node, group in made._asdict().items()})
    file.write_text(parameter_file(made, {}, ['tune --output \'a\nb: [\x85\u2028\udcff.yaml\'']))
    assert file.read_text().startswith("# tune --output 'a\\nb: [\\x85\\u2028\\udcff.yaml'\n")
    assert configure(load([file])) == made
