// @ts-check
// The bar above the charts: time, zoom, the runs, and values or differences.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  function button(text, title, act) {
    const made = mrc.element('button', '', text, {type: 'button', title});
    made.addEventListener('click', act);
    return made;
  }

  // Put the bar before the first of the elements with charts.
  mrc.chartBar = function (view, hosts) {
    const first = hosts.find((host) => host.closest('figure').classList.contains('charted'));
    if (!first) return;
    const {data, clock} = view, bar = mrc.element('div', 'chart-bar scroll'), player = mrc.makePlayer(clock);
    const time = mrc.element('a', 'time', '', {title: 'A link to this time'});
    bar.setAttribute('role', 'toolbar');
    bar.setAttribute('aria-label', 'Charts');
    const zoom = (factor) => {
      const half = factor * (view.range[1] - view.range[0]) / 2;
      const middle = Math.min(Math.max(clock.time, data.start + half), data.end - half);
      if (factor < 1 || view.zoomed) view.setRange(middle - half, middle + half);
    };
    const whole = button('whole run', 'Show all of the time (double click in a chart)',
                         () => view.setRange(data.start, data.end));
    if (mrc.replay) {
      const small = bar.appendChild(mrc.element('canvas'));
      small.setAttribute('role', 'img');
      small.setAttribute('aria-label', 'The robots at this time');
      mrc.replay.copyTo(small);
    }
    bar.append(player.play, player.bar, time, button('+', 'Zoom in at the time shown (drag in a chart)', () => zoom(0.5)),
               button('−', 'Zoom out', () => zoom(2)), whole);
    if (view.several) {
      data.runs.forEach((run, n) => {
        const entry = mrc.switchOf(view, `run ${n}`, run.name, mrc.strokeOf(run));
        entry.button.title = 'Switch this run on or off, in every chart';
        bar.append(entry.button);
      });
      const compare = button('differences', `Show each run minus the first, ${data.runs[0].name}`, () => {
        view.difference = !view.difference;
        compare.setAttribute('aria-pressed', String(view.difference));
        view.changed('lines');
      });
      compare.setAttribute('aria-pressed', 'false');
      bar.append(compare);
    }
    const show = () => {
      time.textContent = `t = ${view.time().toFixed(2)} s`;
      time.href = `#t=${view.time().toFixed(2)}`;
      whole.disabled = !view.zoomed;
    };
    view.onChange(show);
    show();
    const grid = first.closest('.grid') || first;
    grid.before(bar, mrc.element('p', 'soft hint', 'Drag across a chart to zoom, double click to see the whole run; '
      + 'a click sets the time. The names above each chart switch lines on and off.'));
  };
}(window.mrc));
