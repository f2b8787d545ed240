"""The parameter file that a search writes."""

import yaml

from mobile_robot_control.search.result import parameter_file
from mobile_robot_control.settings.configure import configure
from mobile_robot_control.settings.files import load
from mobile_robot_control.settings.nodes import Configuration


def test_a_file_loads_as_it_was_without_empty_sections_and_its_notes_stay_comments(tmp_path):
    shared = Configuration().plant.shared._replace(odom_frame_id='y', base_frame_id='1_0')
    made = Configuration(plant=Configuration().plant._replace(initial_pose=(2.0, 0.0, 0.0)))
    made = made._replace(**{node: group._replace(shared=shared) for node, group in made._asdict().items()})
    for configuration, notes, head in (
            (Configuration(), ['found by hand', ''], '# found by hand\n#\n'),
            (made, ["tune --output 'a\nb: [\x85\u2028\udcff.yaml'"],
             "# tune --output 'a\\nb: [\\x85\\u2028\\udcff.yaml'\n")):
        file = tmp_path / 'gains.yaml'
        file.write_text(parameter_file(configuration, {}, notes))
        assert file.read_text().startswith(head)
        assert configure(load([file])) == configuration
        assert ('/**/plant' in yaml.safe_load(file.read_text())) == (configuration == made)
