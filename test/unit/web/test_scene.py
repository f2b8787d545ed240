"""The drawing of robots in a real browser: where things are, which colours they have, what is left out."""

import base64
import hashlib
import math
import re
import struct
from pathlib import Path

import pytest

import mobile_robot_control
from mobile_robot_control.figures import palette
from mobile_robot_control.pages.page import asset, pack

PAGE = '''<!DOCTYPE html><meta charset="utf-8"><style>{colours} body{{margin:0}}
canvas{{display:block;width:700px;height:400px}}</style><canvas></canvas><script>{script}</script><script>
const canvas = document.querySelector('canvas');
const reader = canvas.getContext('2d', {{willReadFrequently: true}});
function pixel(x, y) {{ return [...reader.getImageData(Math.round(x), Math.round(y), 1, 1).data.slice(0, 3)]; }}
function hex(x, y) {{ return '#' + pixel(x, y).map((n) => n.toString(16).padStart(2, '0')).join(''); }}
function count(colour) {{ const data = reader.getImageData(0, 0, 700, 400).data; let found = 0;
  for (let n = 0; n < data.length; n += 4) if (`#${{[...data.slice(n, n + 3)].map((part) =>
    part.toString(16).padStart(2, '0')).join('')}}` === colour) found += 1; return found; }}
const robot = {{name: 'first', colour: '--robot-1', shape: 'square', wheelSeparation: 0.4, wheelRadius: 0.05}};
const other = {{name: 'second', colour: '--robot-2', shape: 'circle', wheelSeparation: 0.4, wheelRadius: 0.05}};
const path = {{x: [-1, 1, 1, -1], y: [-1, -1, 1, 1], closed: true}};
</script>'''


@pytest.fixture
def scene(browser, tmp_path):
    """Shows a page with the drawing module; returns what evaluates expressions in it."""
    def show(scheme='light'):
        file = tmp_path / 'scene.html'
        file.write_text(PAGE.format(colours=asset('colours.css'), script=asset('basics.js') + asset('scene.js')),
                        encoding='utf-8')
        browser.show(file, 800, scheme)
        return browser.evaluate

    yield show
    assert browser.errors() == []


def test_screen_and_world_are_inverse(scene):
    assert scene()('''(() => {
      const made = mrc.makeScene(canvas, {robots: [robot], path});
      return made.toWorld(...made.toScreen(0.3, -0.7)); })()''') == pytest.approx([0.3, -0.7])


def test_the_view_holds_the_path_to_one_scale(scene):
    left, right, low, top, ahead, aside = scene()('''(() => {
      const made = mrc.makeScene(canvas, {robots: [robot], path});
      const at = (x, y) => made.toScreen(x, y);
      return [at(-1, 0)[0], at(1, 0)[0], at(0, -1)[1], at(0, 1)[1],
              at(1, 0)[0] - at(0, 0)[0], at(0, 0)[1] - at(0, 1)[1]]; })()''')
    assert 0 < left < right < 700
    assert 0 < top < low < 400
    assert ahead == pytest.approx(aside)


@pytest.mark.parametrize(('scheme', 'second'), [('light', '#d55e00'), ('dark', '#ff8c42')])
def test_robots_have_their_colours_and_the_first_one_is_on_top(scene, scheme, second):
    here, there, on_top, name = scene(scheme)('''(() => {
      const made = mrc.makeScene(canvas, {robots: [robot, other], path}), pose = [0, 0, 0];
      const at = (x, y, down) => { const [px, py] = made.toScreen(x, y); return hex(px - 6, py + down); };
      made.draw({robots: [{pose: [0.5, 0.5, Math.PI / 2]}, {pose: [-0.5, 0.5, Math.PI / 2]}]});
      const apart = [at(0.5, 0.5, 3), at(-0.5, 0.5, 3)];
      made.draw({robots: [{pose}, {pose}]});
      return [...apart, at(0, 0, 4), getComputedStyle(canvas).getPropertyValue('--robot-1')]; })()''')
    assert (here, there, on_top) == (name, second, name)


def test_wheels_turn(scene):
    first, turned, again = scene()('''(() => {
      const made = mrc.makeScene(canvas, {robots: [robot], path});
      return [0, 0.4, Math.PI / 3].map((angle) => {
        made.draw({robots: [{pose: [0, 0, 0], wheels: [angle, 0]}]}); return canvas.toDataURL(); }); })()''')
    assert turned != first == again


def test_trails_show_large_errors(scene):
    assert scene()('''(() => {
      const made = mrc.makeScene(canvas, {robots: [robot], path: null, errorScale: 0.1});
      const trail = {x: [-1, -0.5, 0, 0.5, 1], y: [0, 0, 0, 0, 0], error: [0, 0, 0, 0.2, 0.2], from: 0, to: 4};
      made.fit(trail.x, trail.y);
      made.draw({robots: [{pose: null, trail}]});
      return [hex(...made.toScreen(-0.75, 0)), hex(...made.toScreen(0.75, 0))]; })()''') == ['#4a9bd1', '#5c0010']


def test_torques_are_bars_as_long_as_their_part_of_the_limit(scene):
    nothing, zero, half, full, beyond, unknown = scene()('''(() => {
      const made = mrc.makeScene(canvas, {robots: [robot], path});
      return [null, [0, 0], [0.5, -0.5], [1, -1], [7, -7], [NaN, NaN]].map((torque) => {
        made.draw({robots: [{pose: null, torque, limit: 1}]});
        let found = 0;
        for (let x = 520; x < 620; x++) for (const y of [50, 68]) found += hex(x, y) === '#1f2328';
        return found; }); })()''')
    assert (nothing, zero, unknown, beyond) == (0, 0, 0, full)
    assert full > 60
    assert half == pytest.approx(full / 2, abs=3)


@pytest.mark.parametrize(('scheme', 'width'), [('light', 700), ('dark', 360)])
def test_a_drawn_path_has_the_colours_of_its_speed_and_a_bar_beside_that_of_errors(scene, scheme, width):
    before, after, colours, bar, slow, fast, dashed = scene(scheme)('''(() => {
      canvas.style.width = `${WIDTH}px`;
      let words = [], bar = [];
      const prototype = CanvasRenderingContext2D.prototype, {fillText, fillRect} = prototype;
      prototype.fillText = function (...given) { words.push(given); fillText.apply(this, given); };
      prototype.fillRect = function (...given) {
        if (given[3] === 10) bar.push([this.fillStyle, given[1]]); fillRect.apply(this, given); };
      const made = mrc.makeScene(canvas, {robots: [robot], path: null, errorScale: 0.05});
      const trail = {x: [0, 1], y: [0, 0], error: [0, 0], from: 0, to: 1};
      const shown = (drawing) => {
        [words, bar] = [[], []];
        made.draw({robots: [{pose: null, torque: [1, 0], limit: 1, trail}], drawing});
        return words.map(([word]) => word); };
      made.fit([-2, 2], [-2, 2], true);
      const points = [[-1, 1, ''], [1, 1, '']], before = shown({points, cursor: null});
      const x = Array.from({length: 41}, (_, n) => -1 + n / 20), y = x.map(() => 1);
      const after = shown({points, x, y, speed: x.map((one) => one < 0 ? 0.001 : 0.4), most: 0.4});
      const at = (place) => hex(...made.toScreen(place, 1)), style = getComputedStyle(canvas);
      const colours = ['slow', 'fast'].map((name) => style.getPropertyValue(`--speed-${name}`).trim());
      const edges = [bar[16], bar[31]], seen = [at(-0.525), at(0.525)];
      shown({points, x, y, speed: x.map(() => -0.4), most: 0.4});
      const dashed = x.filter((one) => at(one - 0.025) === seen[1]).length;
      return [before, after, colours, edges, ...seen, dashed]; })()'''.replace('WIDTH', str(width)))
    assert set(after) - set(before) == {'speed  0', '0.4 m/s'}
    assert {'first', 'L', 'R', '1.00 N m', 'error  0', '1', '2', 'x [m]', 'y [m]'} <= set(before)
    assert [colour for colour, _ in bar] == colours == [slow, fast]
    assert 10 < dashed < 30


def test_a_number_that_is_not_known_is_not_drawn(scene):
    assert scene()('''(() => {
      const made = mrc.makeScene(canvas, {robots: [robot, other], path: null, errorScale: 0.1});
      made.fit([NaN, Infinity], [0, 0]);
      made.draw({robots: [{pose: null, torque: null, trail: null}, {pose: [0, NaN, 0], wheels: [NaN, 1]}],
                 cart: [NaN, 0, 0]});
      return count('#d55e00') < 240 && made.toWorld(350, 200).every(Number.isFinite); })()''')


def test_a_robot_far_away_is_an_arrow_that_leaves_the_view_as_it_is(scene):
    seen, width = scene()('''(() => {
      const made = mrc.makeScene(canvas, {robots: [robot], path});
      made.fit([1e6], [0]);
      made.draw({robots: [{pose: [1e6, 0, 0]}]});
      return [count('#0072b2'), made.toWorld(700, 0)[0]]; })()''')
    assert seen > 20
    assert width < 8.0


def test_the_colours_of_robots_are_those_of_the_figures():
    light, dark = asset('colours.css').split('@media screen')
    for n, (colour, _) in enumerate(palette.LINES, 1):
        assert f'--robot-{n}:{colour};' in re.sub(r'}', ';', light)
        assert f'--robot-{n}:{palette.on_dark(colour)};' in dark


def test_numbers_are_little_endian_floats():
    packed = pack([1.0, -0.25, math.nan])
    one, quarter, nothing = struct.unpack('<3f', base64.b64decode(packed))
    assert (one, quarter) == (1.0, -0.25)
    assert math.isnan(nothing)


def test_uplot_is_the_release_that_its_note_names():
    note = asset('uplot/README.md')
    for file in ('uPlot.iife.min.js', 'uPlot.min.css'):
        content = (Path(mobile_robot_control.__file__).parent / 'web' / 'uplot' / file).read_bytes()
        assert hashlib.sha256(content).hexdigest() in note, file
    assert 'MIT' in asset('uplot/LICENSE')
