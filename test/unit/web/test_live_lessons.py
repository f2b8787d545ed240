"""Lessons of the live page beside a slow server: what it tells late, or in any order, is no wrong number."""

import json
from types import SimpleNamespace

import pytest

from mobile_robot_control.dashboard.lesson_files import read_lessons
from mobile_robot_control.dashboard.markup import PAGE
from mobile_robot_control.dashboard.sampling import COLUMNS

# in place of the server: what the page asks for is kept, and answered by the test
SERVER = '''<script>window.asked = [];
window.WebSocket = class extends EventTarget {
  static OPEN = 1;
  readyState = 1;
  send(text) { const given = JSON.parse(text); if (given.number) window.asked.push(given); }
};</script>'''


class Page:
    """The live page at a lesson, and what its server tells."""

    def __init__(self, browser, folder, lesson):
        file = folder / 'page.html'
        file.write_text(PAGE.replace('<body>', f'<body>{SERVER}'), encoding='utf-8')
        self._browser, self._lesson = browser, lesson
        browser.show(SimpleNamespace(as_uri=lambda: f'{file.as_uri()}#lesson={lesson}'), 1280)
        self.tell('state', self._state('', {}))
        self.tell('lessons', [{'name': one.name, 'fits': True, **one.content} for one in read_lessons('')])

    def tell(self, kind, value):
        self._browser.evaluate(f'mrc.live.{kind}({json.dumps(value)})')

    def _state(self, lesson, run):
        return {'columns': COLUMNS, 'nodes': [], 'refused': 0, 'unreadable': {}, 'events': [], 'ended': {},
                'lesson': lesson, 'changed_laws': [], 'name': '', 'recordings': [], 'failure': '',
                'run': {'number': 0, 'since': 0.0, 'pose': [0.0, 0.0, 0.0], 'values': {}, 'motion': {}, **run}}

    def state(self, lesson, **run):
        """Tell the lesson under way, and the parameters of a run."""
        run['motion'] = run.get('values', {})
        self.tell('state', self._state(lesson, run))

    def drive(self, run, until, torque=1.0, error=0.2):
        """Show the rows of a run up to a time [s]."""
        known = {'run': run, 'right_asked': torque, 'e1': error}
        rows = [[known.get(name, tick / 20 if name == 'time' else 0.0) for name in COLUMNS]
                for tick in range(round(20 * until) + 1)]
        self._browser.evaluate(f"mrc.live.tell('rows', {json.dumps(rows)}.map((row) => Float32Array.from(row)))")

    def asked(self):
        """Return the requests so far."""
        return self._browser.evaluate('window.asked')

    def answer(self, text='', good=True):
        """Answer the last request; the page goes on."""
        self.tell('answer', [self.asked()[-1]['number'], good, text])
        self._browser.evaluate('new Promise((done) => setTimeout(done))')

    def begin(self, run):
        self.answer(str(run))
        self.state(self._lesson, number=run)

    def choose(self, value, *events):
        """Choose in the first control, of which a browser tells by one event or by two."""
        self._browser.evaluate(
            f'(() => {{ const field = document.querySelector("#lesson .controls select"); field.value = "{value}";'
            f'{json.dumps(events)}.forEach((kind) => field.dispatchEvent(new Event(kind)));'
            'return new Promise((done) => setTimeout(done)); })()')

    def check(self, given):
        """Answer the question, and return what is said of it."""
        return self._browser.evaluate(
            '(() => { const form = document.querySelector("#lesson form");'
            'const words = document.querySelector("#lesson .verdict");'
            f'form.querySelector("input, select").value = "{given}"; words.textContent = ""; form.requestSubmit();'
            'return new Promise((done) => { const look = () => words.textContent ? done(words.textContent)'
            ': setTimeout(look, 10); look(); }); })()')

    def enabled(self):
        """Return how many of its controls can be used, and whether it can be seen."""
        return self._browser.evaluate(
            '[[...document.querySelectorAll("#lesson .controls :is(input, select), #lesson form :is(input, select,'
            ' button:not([type]))")].filter((one) => !one.disabled).length, !document.getElementById("lesson").hidden]')


@pytest.fixture
def opened(browser, tmp_path):
    yield lambda lesson: Page(browser, tmp_path, lesson)
    assert browser.errors() == []


def test_controls_are_disabled_until_the_run_of_the_lesson_has_begun(opened):
    page = opened('3_hybrid')
    assert page.asked()[-1]['name'] == '3_hybrid'
    # the page was loaded again: the server ends the lesson of the page before
    for before in ('3_hybrid', ''):
        page.state(before)
        assert page.enabled() == [0, True]
    page.begin(4)
    assert page.enabled() == [4, True]
    # another page has ended it
    page.state('')
    assert page.enabled()[1] is False


def test_a_lesson_that_does_not_begin_tells_why_and_stays_disabled(opened):
    page = opened('3_hybrid')
    page.answer('no new run began', good=False)
    assert page.enabled() == [0, True]
    assert page._browser.evaluate('document.querySelector("#lesson .verdict").textContent').startswith(
        'no new run began. The lesson has not begun')


def _law(name, **others):
    return {'values': {'position_controller.controller_type': name}, **others}


def test_a_run_counts_for_the_law_that_it_had_whenever_the_page_hears_of_it(opened):
    page = opened('3_hybrid')
    page.begin(4)
    page.drive(4, 1.2, torque=1.95)
    page.state('3_hybrid', number=4, **_law('backstepping'))
    # another run of the same law, in which the other law is chosen; the server is slow
    page.drive(5, 0.5, torque=1.95)
    page.state('3_hybrid', number=5, **_law('backstepping'))
    page.choose('hybrid_backstepping', 'input', 'change')
    assert [one['do'] for one in page.asked()] == ['lesson', 'move']
    page.drive(5, 1.2, torque=1.95)
    page.answer('6')
    page.drive(5, 1.3, torque=1.95)
    # changed at the end of that run, whose parameters are told before the rows of the next one
    page.state('3_hybrid', number=5, since=1.3, **_law('hybrid_backstepping'))
    page.drive(5, 1.4, torque=1.95)
    page.state('3_hybrid', number=6, **_law('hybrid_backstepping'))
    page.drive(6, 0.8, torque=0.05)
    assert page.check('backstepping').startswith('Try both')
    page.drive(6, 1.2, torque=0.079)
    assert page.check('backstepping').startswith(
        'Right. Measured: backstepping 1.95 N m, hybrid_backstepping 0.079 N m.')
    # changed from elsewhere in the first second: this run is of neither law
    page.drive(7, 1.2, torque=9.0)
    page.state('3_hybrid', number=7, **_law('hybrid_backstepping'))
    page.drive(7, 1.3, torque=9.0)
    page.state('3_hybrid', number=7, since=0.4, **_law('backstepping'))
    page.drive(7, 1.4, torque=9.0)
    assert page.check('backstepping').startswith('Try both')
    # from another start
    page.drive(8, 1.2, torque=0.3)
    page.state('3_hybrid', number=8, pose=[1.0, 0.0, 0.0], **_law('hybrid_backstepping'))
    page.drive(8, 1.3, torque=0.3)
    assert page.check('backstepping') == 'Start both from the same place.'


def test_a_parameter_is_known_with_its_run_and_one_of_another_run_does_not_count(opened):
    page = opened('5_windup')
    page.begin(2)
    name = 'velocity_controller.max_wheel_torque'
    page.drive(2, 10.2, error=0.4)
    page.state('5_windup', number=2, values={name: 0.3})
    assert page.check('0.4') == f'First set {name} to 0.'
    page.choose('0', 'change')
    page.answer('3')
    # its rows and parameters have not come yet, then the parameters of all nodes have not
    assert page.check('0.4') == 'The new run has not come yet: check again.'
    page.drive(3, 10.2, error=1.2)
    page.state('5_windup', number=3, values={name: 0.0})
    assert page.check('1.2').startswith('Right. Measured: 1.2 m.')
    page.state('5_windup', number=3, since=6.0, values={name: 0.0})
    assert page.check('1.2') == 'Reset: this run has its parameters only since t = 6 s.'
