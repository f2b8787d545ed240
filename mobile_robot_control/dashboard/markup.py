"""The page; its content comes over the socket and is set as text."""

from mobile_robot_control.pages.page import asset

_SCRIPTS = ('uplot/uPlot.iife.min.js', 'basics.js', 'marks.js', 'scene.js', 'live.js', 'live_stage.js',
            'live_charts.js', 'live_parameters.js', 'live_surface.js', 'live_path.js', 'live_lessons.js',
            'live_page.js')
_STYLES = ('uplot/uPlot.min.css', 'colours.css', 'live.css')
_SKELETON = """
<main id="live">
 <header>
  <h1><span id="name"></span>mobile_robot_control</h1>
  <p id="run" class="soft">connecting</p>
  <p id="spoken" class="unseen" role="status"></p>
 </header>
 <div id="notice" role="alert" hidden><p></p><button id="close-notice" aria-label="close this notice">✕</button></div>
 <div class="bar" id="bar">
  <button id="pause" title="Space">Pause</button>
  <button id="step" title="one position tick, while the run is held">Step</button>
  <button id="reset" title="R">Reset</button>
  <button id="place" aria-pressed="false" title="drag on the plane, use the arrow keys, or write numbers">
   Place the start</button>
  <label>speed <select id="speed"></select></label>
  <label>law <select id="law"></select></label>
  <span id="gains" class="soft"></span>
  <button id="ship" hidden>Take the shipped gains</button>
  <button id="undo-law" hidden>Undo</button>
  <label>velocity law <select id="velocity-law"></select></label>
  <button id="read-law" hidden>Read the law again</button>
  <button id="record">Record</button>
  <span id="recorded" class="soft"></span>
  <button id="save">Save parameters</button>
  <span id="saved" class="soft"></span>
  <button id="lessons">Lessons</button>
 </div>
 <form class="bar" id="placing" hidden>
  <label>x [m] <input name="x" inputmode="decimal" size="6"></label>
  <label>y [m] <input name="y" inputmode="decimal" size="6"></label>
  <label>heading [rad] <input name="heading" inputmode="decimal" size="6"></label>
  <button>Start here</button>
  <span class="soft" id="hint"></span>
 </form>
 <div class="halves" id="view">
  <section aria-label="the robot on the plane" id="plane">
   <canvas id="scene" tabindex="0" role="img" aria-label="the robot on the plane"></canvas>
   <dl id="numbers" class="numbers"></dl>
   <div class="bar" id="disturbances">
    <span class="soft">disturb</span>
    <button data-key="ArrowUp" title="arrow up" aria-label="push ahead">↑</button>
    <button data-key="ArrowDown" title="arrow down" aria-label="push back">↓</button>
    <button data-key="ArrowLeft" title="arrow left" aria-label="turn to the left">↺</button>
    <button data-key="ArrowRight" title="arrow right" aria-label="turn to the right">↻</button>
   </div>
  </section>
  <section id="charts" aria-label="charts"></section>
  <section id="lesson" aria-label="lesson" hidden></section>
 </div>
 <div class="halves" id="rest">
  <section>
   <h2>Parameters</h2>
   <p class="soft">A marked one differs from its default. <button id="defaults">All defaults</button></p>
   <div id="curve"></div>
   <div id="parameters"></div>
  </section>
  <section>
   <h2>Draw a path</h2>
   <div id="path"></div>
   <h2>Nodes</h2>
   <div id="nodes"></div>
   <details id="changes"><summary>What changed the run</summary><ol class="soft"></ol></details>
   <details id="topics"><summary>Topics</summary>
    <div class="scroll" tabindex="0" role="region" aria-label="topics"><table>
    <thead><tr><th>topic, last message</th><th class="number">rate [Hz]</th></tr></thead>
    <tbody></tbody></table></div></details>
  </section>
 </div>
</main>
"""
PAGE = ''.join([
    '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
    '<meta name="viewport" content="width=device-width, initial-scale=1">\n<title>mobile_robot_control</title>\n'
    '<link rel="icon" href="data:,">\n',
    *(f'<style>{asset(name)}</style>\n' for name in _STYLES), '</head>\n<body>', _SKELETON,
    *(f'<script>{asset(name)}</script>\n' for name in _SCRIPTS), '</body>\n</html>\n',
])
"""The whole page, with its styles and scripts: nothing comes from elsewhere."""
