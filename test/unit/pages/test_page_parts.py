"""Generated parts of pages, and the commands that they are measured with."""

import pytest
from command_output import output_of
from page_part import PagePart

PART = PagePart('results')


def test_a_part_is_inserted_between_its_marks():
    made = PART.marked('1', ['NEW'])
    assert made == '<!-- results: generated from 1 -->\n\nNEW\n\n<!-- end of results -->'
    assert PART.inserted('a\n<!-- results: generated -->\nOLD\n<!-- end of results -->\nb\n', made) == f'a\n{made}\nb\n'
    assert PART.found(f'a {made} b') == made
    assert PART.found('a page without it') == ''


def test_the_part_of_another_name_stays(tmp_path):
    other = PagePart('other').marked('2', ['KEPT'])
    page = tmp_path / 'page.md'
    page.write_text(f'{other}\n{PART.marked("1", ["OLD"])}\n')
    PART.write([str(page)], PART.marked('3', ['NEW']))
    assert page.read_text() == f'{other}\n{PART.marked("3", ["NEW"])}\n'


def test_a_command_that_fails_is_named_with_what_it_printed():
    with pytest.raises(RuntimeError, match=r'simulate --robot nothing: exit code 2: .*there is no robot of this name'):
        output_of('simulate --robot nothing', '--duration', '1')
