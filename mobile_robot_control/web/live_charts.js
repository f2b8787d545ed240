// @ts-check
// Rolling charts of the live page: errors, velocities, torques with their limits, the Lyapunov function; marks of
// events; and the newest numbers, or those under the cursor, as text.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  const SPAN = 60, EVERY = 100, HEIGHT = 164, LOW = 119;  // [s] shown, [ms] between drawings, [px], [px] in a lesson on a phone
  const RIGHT = 56;  // [px] of the right axis
  const CHARTS = [
    {name: 'errors', title: 'errors', unit: 'm', right: 'rad', lines: [
      ['e1', '--robot-1'], ['e2', '--robot-2'], ['e3', '--robot-3', 'right']]},
    {name: 'velocities', title: 'velocities', unit: 'm/s', right: 'rad/s', limits: [['limits.linear_velocity'],
      ['limits.angular_velocity', 'right']], lines: [
      ['linear', '--robot-1'], ['cmd_linear', '--robot-1', '', 'dashed'], ['angular', '--robot-2', 'right'],
      ['cmd_angular', '--robot-2', 'right', 'dashed']]},
    {name: 'torques', title: 'torques', unit: 'N m', limits: [['max_wheel_torque']], lines: [
      ['right_applied', '--robot-1'], ['left_applied', '--robot-2'], ['right_asked', '--robot-1', '', 'dashed'],
      ['left_asked', '--robot-2', '', 'dashed']]},
    {name: 'lyapunov', title: 'Lyapunov function (26)', unit: '', lines: [['lyapunov', '--robot-1']], only: 'lyapunov'},
  ];
  const NAMES = {
    e1: 'e1 ahead', e2: 'e2 to the left', e3: 'e3 heading', linear: 'v', cmd_linear: 'v asked for', angular: 'ω',
    cmd_angular: 'ω asked for', right_applied: 'right', left_applied: 'left', right_asked: 'right asked for',
    left_asked: 'left asked for', lyapunov: 'V'};

  const UNITS = {e1: 'm', e2: 'm', e3: 'rad', linear: 'm/s', angular: 'rad/s', right_applied: 'N m', left_applied: 'N m',
    cmd_linear: 'm/s', cmd_angular: 'rad/s', right_asked: 'N m', left_asked: 'N m'};
  const SHOWN = ['e1', 'e2', 'e3', 'linear', 'angular', 'right_applied', 'left_applied'];

  // Return a range for each of two scales, with zero at one height, from their values.
  function ranges(sides) {
    const found = sides.map((values) => values.reduce(
      ([low, high], value) => value === null ? [low, high] : [Math.min(low, value), Math.max(high, value)], [0, 0]));
    const sizes = found.map(([low, high]) => Math.max(-low, high) || 1);
    const below = Math.max(...found.map(([low], n) => -low / sizes[n])), above = Math.max(
      ...found.map(([, high], n) => high / sizes[n]));
    return sizes.map((size) => [-1.08 * Math.max(below, 0.05) * size, 1.08 * Math.max(above, 0.05) * size]);
  }

  // Return a text with short numbers.
  const short = (text) => text.replace(/-?\d+\.\d{4,}(e[-+]?\d+)?/g, (number) => mrc.number(Number(number)));

  // Write the units of both axes above their numbers, and the name of the time axis at its end.
  function nameAxes(plot, {unit, right}) {
    const {left, width, top, height} = plot.bbox, pen = plot.ctx, ratio = window.devicePixelRatio || 1;
    pen.save();
    pen.fillStyle = mrc.colour('--soft');
    pen.font = `${12 * ratio}px system-ui`;
    pen.textAlign = 'right';
    pen.textBaseline = 'alphabetic';
    if (unit) pen.fillText(`[${unit}]`, left - 5 * ratio, top - 8 * ratio);
    pen.textAlign = 'left';
    if (right) pen.fillText(`[${right}]`, left + width + 5 * ratio, top - 8 * ratio);
    pen.fillText('t [s]', left + width + 14 * ratio, top + height + 17 * ratio);
    pen.restore();
  }

  // Make one chart in a container; returns {draw(rows), limits(values), figure}.
  function makeChart(container, spec, read, shared) {
    const figure = mrc.element('figure'), caption = mrc.element('figcaption');
    caption.append(mrc.element('b', '', spec.title));
    const values_ = spec.lines.map(([column, ink, side, dashed]) => {
      const key = mrc.element('span', `key ${dashed || ''}`), stroke = mrc.element('i'), value = mrc.element('span', 'value');
      stroke.style.borderColor = `var(${ink})`;
      const unit = [UNITS[column], side && 'right axis'].filter(Boolean).join(', ');
      key.append(stroke, NAMES[column] + (unit && ` [${unit}]`), value);
      caption.append(key);
      return value;
    });
    const place = mrc.element('div');
    figure.append(caption, place);
    container.append(figure);
    figure.dataset.chart = spec.name;
    const limits = (spec.limits || []).flatMap(([parameter, side]) => [1, -1].map((sign) => ({parameter, side, sign})));
    let values = {};
    const axis = (scale, side) => ({scale, side, stroke: () => mrc.colour('--soft'), size: side === 1 ? RIGHT : 64, font: '12px system-ui',
      grid: {show: side === 3, stroke: () => mrc.colour('--faint'), width: 1}, ticks: {show: false},
      values: (_, ticks) => ticks.map((tick) => tick === null ? '' : mrc.number(tick))});
    const plot = new uPlot({
      width: Math.max(200, container.clientWidth), height: HEIGHT, legend: {show: false},
      cursor: {y: false, sync: {key: 'live', scales: ['x', null]}},
      padding: [24, spec.right ? 0 : RIGHT, 0, 0],  // so that the times of all charts stand one below the other
      scales: {x: {time: false}, left: {auto: false}, right: {auto: false}},
      hooks: {draw: [(drawn) => { mrc.drawMarks(drawn, shared.events, spec === CHARTS[0], true); nameAxes(drawn, spec); }], setCursor: [() => tell()]},
      axes: [{stroke: () => mrc.colour('--soft'), size: 22, font: '12px system-ui', grid: {show: false}, ticks: {show: false}},
             axis('left', 3), ...(spec.right ? [axis('right', 1)] : [])],
      series: [{}, ...spec.lines.map(([, ink, side, dashed]) => ({
        scale: side || 'left', stroke: () => mrc.colour(ink), width: 1.5, dash: dashed ? [5, 4] : undefined,
        points: {show: false}})),
      ...limits.map(({side}) => ({scale: side || 'left', stroke: () => mrc.colour('--warn'), width: 1, dash: [2, 3],
                                  points: {show: false}}))],
    }, [[], ...spec.lines.map(() => []), ...limits.map(() => [])], place);
    plot.over.setAttribute('role', 'img');
    const size = () => plot.setSize({width: Math.max(200, container.clientWidth),
                                     height: shared.only && window.innerWidth < 600 ? LOW : HEIGHT});
    new ResizeObserver(size).observe(container);
    let told = '';
    // Write the numbers under the cursor, or the newest.
    function tell() {
      const {idx, left} = plot.cursor, times = plot.data[0], n = left >= 0 && idx !== null && idx !== undefined ? idx : times.length - 1;
      spec.lines.forEach(([column, , side], k) => {
        const value = n >= 0 ? plot.data[k + 1][n] : null;
        values_[k].textContent = value === null || value === undefined ? '' : mrc.number(value, '', 3);
      });
      const words = `${spec.title} over the last minute` + (n >= 0 ? `; at ${mrc.number(times[n], 's', 4)}: ${
        spec.lines.map(([column], k) => `${NAMES[column]} ${values_[k].textContent}`).join(', ')}` : '');
      // not with each row: a screen reader would be told again and again
      if (performance.now() - shared.told > 5000 || !told) { told = words; plot.over.setAttribute('aria-label', words); }
    }
    const number = (value) => Number.isFinite(value) ? value : null;
    return {
      figure,
      setLimits(given) { values = given; },
      draw(rows) {
        figure.hidden = shared.only ? shared.only !== spec.name
          : Boolean(spec.only) && (!rows.length || !Number.isFinite(read[spec.only](rows[rows.length - 1])));
        if (figure.hidden) return;
        plot.setData([
          rows.map(read.time), ...spec.lines.map(([column]) => rows.map((row) => number(read[column](row)))),
          ...limits.map(({parameter, sign}) => {
            const value = values[parameter] > 0 ? sign * values[parameter] : null;
            return rows.map(() => value);
          })], false);
        const of = (which) => plot.data.slice(1).filter((_, n) => (plot.series[n + 1].scale === which)).flat();
        const [left, right] = ranges([of('left'), of('right')]);
        plot.batch(() => {
          plot.setScale('x', {min: Math.max(0, (plot.data[0].at(-1) || 0) - SPAN), max: Math.max(plot.data[0].at(-1) || 0, 1)});
          plot.setScale('left', {min: left[0], max: left[1]});
          plot.setScale('right', {min: right[0], max: right[1]});
        });
        tell();
      },
      size,
      redraw() { plot.redraw(false); },
    };
  }

  // Fill a list with names, and return the function that writes numbers of a row.
  function makeNumbers(list, columns, read) {
    list.textContent = '';
    const places = columns.map((column) => {
      const place = mrc.element('dd'), box = mrc.element('div');
      box.append(mrc.element('dt', '', NAMES[column] || column), place);
      list.append(box);
      return place;
    });
    return (row) => columns.forEach((column, n) => {
      const value = read[column](row);
      places[n].textContent = Number.isFinite(value) ? `${value.toFixed(3).replace('-', '−')} ${UNITS[column] || ''}` : '–';
    });
  }

  // Fill a container with the charts, and a list with numbers; they follow the rows that come. Returns
  // {only(name, columns)}: the chart and the numbers of a lesson alone, or all of them for null.
  mrc.makeCharts = function (container, list) {
    let rows = [], charts = [], run = null, drawn = 0, read = null, write = null;
    const shared = {events: [], only: '', told: 0};
    mrc.live.on('columns', (columns) => {
      read = Object.fromEntries(columns.map((name) => [name, mrc.live.column(name)]));
      charts = CHARTS.map((spec) => makeChart(container, spec, read, shared));
      write = makeNumbers(list, SHOWN, read);
    });
    mrc.live.on('rows', (added) => {
      for (const row of added) {
        if (read.run(row) !== run) { run = read.run(row); rows = []; }
        // while time stands still there is nothing to add
        const last = rows.length ? read.time(rows[rows.length - 1]) : -1;
        if (read.time(row) > last) rows.push(row); else if (rows.length) rows[rows.length - 1] = row;
      }
      const newest = rows.length ? read.time(rows[rows.length - 1]) : 0;
      let first = 0;
      while (first < rows.length && read.time(rows[first]) < newest - SPAN) first += 1;
      if (first) rows = rows.slice(first);
      const now = performance.now();
      if (now - drawn >= EVERY) {
        drawn = now;
        charts.forEach((chart) => chart.draw(rows));
        if (now - shared.told > 5000) shared.told = now;
        if (rows.length) write(rows[rows.length - 1]);
      }
    });
    mrc.live.on('state', ({events}) => {
      // newest first: those of the run before the last reset are of another time
      const reset = events.findIndex(({text}) => text.startsWith('reset'));
      shared.events = (reset < 0 ? events : events.slice(0, reset))
        .filter(({stamp}) => stamp < 1e9).map(({stamp, text}) => ({time: stamp, text: short(text)})).reverse();
    });
    mrc.live.on('parameters', ({nodes}) => {
      const limits = {};
      for (const {values} of nodes) {
        for (const name of ['max_wheel_torque', 'limits.linear_velocity', 'limits.angular_velocity']) {
          if (values[name] > 0) limits[name] = Math.min(values[name], limits[name] || Infinity);
        }
      }
      charts.forEach((chart) => chart.setLimits(limits));
    });
    mrc.onDark(() => charts.forEach((chart) => chart.redraw()));
    return {
      only(name, columns) {
        shared.only = name || '';
        container.hidden = name === 'none';
        write = makeNumbers(list, columns || SHOWN, read);
        charts.forEach((chart) => { chart.draw(rows); chart.size(); });
        if (rows.length) write(rows[rows.length - 1]);
      },
    };
  };
}(window.mrc));
