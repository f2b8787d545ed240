"""The tables of robots: each number with the comment above it."""

from robots_table import (
    SourcedParameter,
    head,
    insert_robots,
    robot_tables,
    sourced_parameters,
)

ROBOT = """# A robot:
#   of some maker.
#
# It has two wheels.
/**:
  ros__parameters:
    # the first of
    # two lines: a | b
    velocity_rate: 100.0
    robot:
      # placeholder: nothing is published
      mass: 1.5    # kg

/**/position_controller:
  ros__parameters:
    # found by: tune --seed 1
    backstepping: {p: 1.0, q: 2.0}

    limits.linear_velocity: 0.2
"""


def test_each_number_has_the_comment_above_it():
    assert sourced_parameters(ROBOT) == [
        SourcedParameter('', 'velocity_rate', '100.0', 'the first of two lines: a | b'),
        SourcedParameter('', 'robot.mass', '1.5', 'placeholder: nothing is published'),
        SourcedParameter('position_controller', 'backstepping.p', '1.0', 'found by: tune --seed 1'),
        SourcedParameter('position_controller', 'backstepping.q', '2.0', 'found by: tune --seed 1'),
        SourcedParameter('position_controller', 'limits.linear_velocity', '0.2', ''),
    ]


def test_the_head_of_a_file_is_its_first_comment():
    assert head(ROBOT) == 'A robot:\n  of some maker.\n\nIt has two wheels.'
    assert head('/**: {}') == ''


def test_a_table_has_units_and_calls_placeholders_so():
    rows = robot_tables({'one': ROBOT}).splitlines()
    assert rows[:2] == ['## one', '']
    assert '| `velocity_rate` | 100.0 | Hz | the first of two lines: a \\| b |' in rows
    assert '| `robot.mass` | 1.5 | kg | **placeholder**: nothing is published |' in rows
    assert '| `position_controller.limits.linear_velocity` | 0.2 | m/s |  |' in rows


def test_the_robots_are_inserted_between_the_marks():
    page = 'before\n<!-- robots: generated -->\nSTALE\n<!-- end of robots -->\nafter\n'
    made = insert_robots(page)
    assert 'STALE' not in made
    assert '## chapter\n' in made
    assert made.startswith('before\n<!-- robots: generated -->\n\n## ')
    assert made.endswith(' |\n\n<!-- end of robots -->\nafter\n')
    assert insert_robots(made) == made
