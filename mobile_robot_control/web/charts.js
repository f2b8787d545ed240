// @ts-check
// Charts of runs over time, drawn with uPlot: one range of time, one cursor and one choice of lines for all of them.
//
//   mrc.showCharts(data, clock)
//
// fills each <div class="charts" data-figure="NAME"> of the page with the charts of that figure, and marks the figure
// around it with the class `charted`, so that its still picture is for paper only. `data` is what
// pages/page_parts.py packs: {start, end, runs: [{name, light, dark, width, dash}], columns: [packed numbers],
// charts: [{figure, label, unit, bend, limits, lines: [{kind, run, name, time, value}]}], ...}; time and value of a line
// are places in `columns`. The kinds are reference, value, command and difference. A click sets the clock, and the
// clock moves the cursor of time.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  const HEIGHT = 216, FONT = '12px system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif';
  // Return the place of the point of a line that is nearest to a time; -1 outside of the line.
  mrc.nearest = function (times, time) {
    const last = times.length - 1, reach = last > 0 ? (times[last] - times[0]) / last : 0;
    if (last < 0 || time < times[0] - reach || time > times[last] + reach) return -1;
    const n = mrc.indexAt(times, time);
    return n < last && times[n + 1] - time < time - times[n] ? n + 1 : n;
  };

  // What all charts share: the range of time that they show, and which lines.
  function makeView(data, clock) {
    /** @type {((what?: string) => void)[]} */
    const listeners = [];
    /** @type {Set<string>} */
    const off = new Set();
    const several = data.runs.length > 1;
    if (several) off.add('commanded');  // as many lines again
    /** @type {View} */
    const view = {
      data, clock, off, several, range: [data.start, data.end], difference: false, hover: null,
      onChange(listener) { listeners.push(listener); },
      changed(what) { listeners.forEach((listener) => listener(what)); },
      get zoomed() { return view.range[0] > data.start || view.range[1] < data.end; },
      setRange(low, high) {
        const [from, to] = [Math.max(low, data.start), Math.min(high, data.end)];
        if (!(to > from) || (from === view.range[0] && to === view.range[1])) return;
        view.range = [from, to];
        view.changed('range');
      },
      toggle(key) {
        if (!off.delete(key)) off.add(key);
        view.changed('lines');
      },
      // The names under which a line is switched off: that of its run, and that of its kind.
      keys(line) {
        const kind = line.kind === 'value' ? (several ? null : line.name) : line.kind === 'difference' ? null : line.name;
        return [several && line.kind !== 'reference' ? `run ${line.run}` : null, kind].filter(Boolean);
      },
      shows(line) {
        const compared = line.kind === 'difference';
        return compared === view.difference && !view.keys(line).some((key) => off.has(key));
      },
      time() { return view.hover === null ? clock.time : view.hover; },
    };
    return view;
  }

  // Return the stroke of a line.
  function stroke(data, line) {
    if (line.kind === 'reference') return {colour: data.reference, width: data.runs[0].width + 2.4, dash: []};
    if (line.kind === 'command' && data.runs.length < 2) return {colour: data.command, width: 1.6, dash: [2, 3]};
    const run = data.runs[line.run];
    if (line.kind === 'command') return {colour: run, width: 1.6, dash: [2, 3]};
    return mrc.strokeOf(run);
  }

  // Return a short piece of a line, for legends; it is repainted when the page turns dark.
  mrc.sample = function (style) {
    const space = 'http://www.w3.org/2000/svg', picture = document.createElementNS(space, 'svg');
    const piece = document.createElementNS(space, 'line');
    for (const [name, value] of Object.entries({width: 30, height: 12, 'aria-hidden': 'true'})) {
      picture.setAttribute(name, String(value));
    }
    const ends = {x1: 1, x2: 29, y1: 6, y2: 6, 'stroke-width': style.width, 'stroke-dasharray': style.dash.join(' ')};
    for (const [name, value] of Object.entries(ends)) piece.setAttribute(name, String(value));
    const paint = () => piece.setAttribute('stroke', mrc.look(style.colour));
    paint();
    mrc.onDark(paint);
    picture.append(piece);
    return picture;
  };

  // Return the stroke of a run.
  mrc.strokeOf = (run) => ({colour: run, width: run.width, dash: run.dash});

  // Return a button of a legend, which switches lines on and off.
  mrc.switchOf = function (view, key, name, style) {
    const button = mrc.element('button', 'switch', '', {type: 'button'});
    button.append(mrc.sample(style), mrc.element('span', 'name', name));
    const value = mrc.element('span', 'value');
    button.append(value);
    button.addEventListener('click', () => view.toggle(key));
    const show = () => button.setAttribute('aria-pressed', String(!view.off.has(key)));
    view.onChange((what) => { if (what === 'lines') show(); });
    show();
    return {button, value};
  };

  // Return the legend of a chart: a switch a line, and its value at the time of the cursor.
  function makeLegend(view, chart, lines) {
    const legend = mrc.element('div', 'legend'), entries = [];
    for (const line of lines) {
      const key = view.keys(line)[line.kind === 'command' ? view.keys(line).length - 1 : 0];
      const commands = view.several && line.kind === 'command';
      if (line.kind === 'difference' || (commands && entries.some((entry) => entry.line.kind === 'command'))) continue;
      const name = view.several && line.kind === 'value' ? view.data.runs[line.run].name
        : line.name;
      const style = commands ? {...stroke(view.data, line), colour: view.data.command} : stroke(view.data, line);
      const alone = lines.length === 1 && !view.several;  // there is nothing to choose
      const {button, value} = alone ? {button: null, value: mrc.element('span', 'value')}
        : mrc.switchOf(view, key, name, style);
      const entry = {line, commands, button, value};
      if (entry.button) entry.button.title = 'Switch this line on or off, in every chart';
      entries.push(entry);
      legend.append(entry.button || entry.value);
    }
    for (const value of new Set(chart.limits.map((limit) => limit.value))) {
      const whose = chart.limits.filter((limit) => limit.value === value).map((limit) => view.data.runs[limit.run].name);
      const of = whose.length < view.data.runs.length ? ` of ${whose.join(', ')}` : '';
      legend.append(mrc.element('span', 'limit', `limit ±${mrc.number(value, chart.unit)}${of}`));
    }
    return {legend, update() {
      for (const entry of entries) {
        const compared = view.difference && lines.find(
          (line) => line.kind === 'difference' && line.run === entry.line.run && entry.line.kind === 'value');
        if (entry.button) entry.button.hidden = view.difference && entry.line.kind !== 'value';
        if (entry.commands) continue;
        const shown = compared || entry.line, n = mrc.nearest(shown.times, view.time());
        entry.value.textContent = view.difference && !compared ? 'first' : n < 0 ? '–'
          : mrc.number(shown.values[n], chart.unit);
      }
    }};
  }

  // Draw the limits of a quantity as far as they are in sight.
  function drawLimits(plot, view, chart) {
    if (view.difference) return;
    const {left, width, top, height} = plot.bbox, pen = plot.ctx;
    for (const limit of chart.limits) {
      for (const y of [limit.value, -limit.value].map((value) => Math.round(plot.valToPos(value, 'y', true)))) {
        if (!(y >= top && y <= top + height)) continue;
        pen.save();
        pen.setLineDash([6, 6]);
        pen.lineWidth = 2;
        pen.strokeStyle = mrc.colour('--warn');
        pen.beginPath();
        pen.moveTo(left, y);
        pen.lineTo(left + width, y);
        pen.stroke();
        pen.restore();
      }
    }
  }

  const axis = (more) => ({
    stroke: () => mrc.colour('--soft'), font: FONT, grid: {stroke: () => mrc.colour('--faint'), width: 1},
    ticks: {show: false}, values: (plot, splits) => splits.map((value) => value === null ? '' : mrc.number(value, '', 8)), ...more,
  });
  const wide = (plot, labels) => Math.max(52, 16 + 7.2 * Math.max(0, ...(labels || []).map((label) => label.length)));

  // Return the options of uPlot for a chart.
  function options(view, chart, lines, width, time) {
    return {
      width, height: HEIGHT, legend: {show: false},
      cursor: {
        y: false, points: {size: 7}, bind: {dblclick: () => null}, drag: {x: true, y: false, setScale: true, dist: 6},
        sync: {key: 'mrc', scales: ['x', null], filters: {pub: (kind) => ['mousemove', 'mouseleave'].includes(kind)}},
      },
      scales: {
        x: {time: false, min: view.range[0], max: view.range[1], range: (plot, min, max) => [min, max]},
        y: chart.bend ? {distr: 4, asinh: chart.bend} : {},
      },
      axes: [axis({size: 26, label: 'time [s]', labelSize: 18, labelFont: FONT}), axis({size: wide, space: 32})],
      series: [{}, ...lines.map((line) => {
        const style = stroke(view.data, line);
        return {label: line.name, show: view.shows(line), width: style.width, dash: style.dash, points: {show: false}, pxAlign: 0,
                stroke: () => mrc.look(style.colour)};
      })],
      hooks: {
        draw: [(plot) => drawLimits(plot, view, chart)],
        setSize: [time.place], setScale: [(plot, name) => { if (name === 'x') time.zoom(plot); }],
        setCursor: [(plot) => time.hover(plot)],
      },
    };
  }

  function makeChart(view, chart, host) {
    const {data, clock} = view, first = !host.querySelector('.chart'), lines = chart.lines.map((line) => ({
      ...line, times: data.columns[line.time], values: data.columns[line.value]}));
    const box = mrc.element('div', 'chart'), mark = mrc.element('div', 'now'), head = mrc.element('div', 'head');
    const unit = chart.unit ? ` [${chart.unit}]` : '', scale = chart.bend ? ', logarithmic scale' : '';
    const {legend, update} = makeLegend(view, chart, lines);
    head.append(mrc.element('h4', '', chart.label + unit + scale), legend);
    const thinned = lines.find((line) => line.thinnedFrom);
    if (thinned) {
      head.append(mrc.element('span', 'soft', `thinned: ${thinned.times.length} of ${thinned.thinnedFrom} points, with `
        + 'every peak'));
    }
    box.append(head);
    host.append(box);
    let plot = null, seen = true;
    const time = {
      place() {
        if (!plot) return;
        const x = plot.valToPos(clock.time, 'x');
        mark.hidden = !(x >= 0 && x <= plot.over.clientWidth);
        mark.style.transform = `translateX(${x}px)`;
      },
      zoom(which) {
        const {min, max} = which.scales.x;
        if (plot && min !== null && (min !== view.range[0] || max !== view.range[1])) view.setRange(min, max);
        time.place();
      },
      hover(which) {
        // the pointer is over one chart; the others follow by uPlot's synchronisation
        if (!plot || !which.cursor.event) return;
        const left = which.cursor.left;
        view.hover = left >= 0 ? which.posToVal(left, 'x') : null;
        view.changed('time');
      },
    };
    const joined = uPlot.join(lines.map(({times, values}) => [
      Array.from(times), Array.from(values, (value) => Number.isFinite(value) ? value : null)]));
    const marks = () => view.data.events.filter(({run}) => !view.off.has(`run ${run}`));
    const chosen = options(view, chart, lines, Math.max(box.clientWidth, 100), time);
    chosen.hooks.draw.push((drawn) => mrc.drawMarks(drawn, marks(), first));
    plot = new uPlot(chosen, joined, box);
    head.append(mrc.viewButtons({
      view, chart, lines, plot, strokeOf: (line) => stroke(data, line),
      nameOf: (line) => view.several && line.kind !== 'reference' ? data.runs[line.run].name : line.name}));
    plot.over.append(mark);
    plot.over.setAttribute('role', 'img');
    plot.over.setAttribute('aria-label', `${chart.label}${unit} over time`);
    let pressed = 0;
    plot.over.addEventListener('mousedown', (event) => { pressed = event.clientX; });
    plot.over.addEventListener('mouseup', (event) => {
      if (Math.abs(event.clientX - pressed) < 6) clock.set(plot.posToVal(event.offsetX, 'x'));
    });
    plot.over.addEventListener('dblclick', () => view.setRange(data.start, data.end));
    new ResizeObserver(() => requestAnimationFrame(() => {
      const width = box.clientWidth;
      if (width > 0 && width !== plot.width) plot.setSize({width, height: HEIGHT});
    })).observe(box);
    new IntersectionObserver((entries) => {
      seen = entries[entries.length - 1].isIntersecting;
      if (seen) { time.place(); update(); }
    }).observe(box);
    view.onChange((what) => {
      if (what === 'range') plot.setScale('x', {min: view.range[0], max: view.range[1]});
      if (what === 'lines') {
        plot.batch(() => lines.forEach((line, n) => {
          if (plot.series[n + 1].show !== view.shows(line)) plot.setSeries(n + 1, {show: view.shows(line)});
        }));
      }
      if (seen) { time.place(); update(); }
    });
    mrc.onDark(() => plot.redraw());
    plot.setScale('x', {min: view.range[0], max: view.range[1]});
    update();
  }

  mrc.showCharts = function (data, clock) {
    data.columns = data.columns.map(mrc.unpack);
    const view = makeView(data, clock), 
      hosts = /** @type {HTMLElement[]} */ ([...document.querySelectorAll('.charts[data-figure]')]);
    clock.onChange(() => view.changed('time'));
    for (const host of hosts) {
      const charts = data.charts.filter((chart) => chart.figure === host.dataset.figure);
      if (host.dataset.figure === 'path' && data.deviation.length) mrc.drawDeviation(view, host);
      else if (!charts.length) continue;
      host.closest('figure').classList.add('charted');
      charts.forEach((chart) => makeChart(view, chart, host));
    }
    mrc.chartBar(view, hosts);
    if (mrc.replay && view.several) mrc.replay.follow(view);
    mrc.markBars(data.events, clock);
    return view;
  };
}(window.mrc));
