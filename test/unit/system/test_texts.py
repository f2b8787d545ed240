"""Texts from elsewhere become one printable line of bounded length."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mobile_robot_control.system.texts import distinct, printable, shortened

TEXTS = st.text(st.characters(codec=None), max_size=40)


@given(TEXTS)
def test_any_text_becomes_one_line_that_can_be_encoded(text):
    shown = printable(text)
    assert shown.isprintable()
    assert shown.encode().decode() == shown
    assert printable(shown) == shown


@pytest.mark.parametrize(('text', 'shown'), [
    ('plain, ü and 日', 'plain, ü and 日'), ('a\nb\r\t', r'a\nb\r\t'), ('\x1b[2J', r'\x1b[2J'), ('\udcff', r'\udcff'),
    ('\u2028\x85', r'\u2028\x85'), ('\ufeff\ufffe', r'\ufeff\ufffe')])
def test_what_cannot_be_shown_is_escaped(text, shown):
    assert printable(text) == shown


@given(TEXTS, st.integers(2, 30))
def test_a_shortened_text_is_no_longer_than_asked_for(text, longest):
    shown = shortened(text, longest)
    assert len(shown) <= longest
    assert shown.isprintable()
    if len(printable(text)) <= longest:
        assert shown == printable(text)


@given(st.lists(st.sampled_from(['', 'a', 'a_1', 'a_2']), max_size=5))
def test_numbered_names_differ_from_all_others(names):
    assert len(set(distinct(names))) == len(names)
