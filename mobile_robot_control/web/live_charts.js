// @ts-check
// Rolling charts of the live page: errors, velocities, torques with their limits, the Lyapunov function.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  const SPAN = 20, EVERY = 100;  // [s] shown, [ms] between two drawings
  const CHARTS = [
    {title: 'errors', unit: 'm', right: 'rad', lines: [
      ['e1', '--robot-1'], ['e2', '--robot-2'], ['e3', '--robot-3', 'right']]},
    {title: 'velocities', unit: 'm/s', right: 'rad/s', limits: [['limits.linear_velocity'],
      ['limits.angular_velocity', 'right']], lines: [
      ['linear', '--robot-1'], ['cmd_linear', '--robot-1', '', 'dashed'], ['angular', '--robot-2', 'right'],
      ['cmd_angular', '--robot-2', 'right', 'dashed']]},
    {title: 'torques', unit: 'N m', limits: [['max_wheel_torque']], lines: [
      ['right_applied', '--robot-1'], ['left_applied', '--robot-2'], ['right_asked', '--robot-1', '', 'dashed'],
      ['left_asked', '--robot-2', '', 'dashed']]},
    {title: 'Lyapunov function (26)', unit: '', lines: [['lyapunov', '--robot-1']], only: 'lyapunov'},
  ];
  const NAMES = {
    e1: 'e1 ahead', e2: 'e2 to the left', e3: 'e3 heading', linear: 'v', cmd_linear: 'v asked for', angular: 'ω',
    cmd_angular: 'ω asked for', right_applied: 'right', left_applied: 'left', right_asked: 'right asked for',
    left_asked: 'left asked for', lyapunov: 'V'};

  // Make one chart in a container; returns {draw(rows), limits(values), figure}.
  function makeChart(container, spec, read) {
    const figure = mrc.element('figure'), caption = mrc.element('figcaption');
    caption.append(mrc.element('b', '', spec.title + (
      spec.unit ? ` [${spec.unit}${spec.right ? `, ${spec.right}` : ''}]` : '')));
    for (const [column, ink, , dashed] of spec.lines) {
      const key = mrc.element('span', `key ${dashed || ''}`), stroke = mrc.element('i');
      stroke.style.borderColor = `var(${ink})`;
      key.append(stroke, NAMES[column]);
      caption.append(key);
    }
    const place = mrc.element('div');
    figure.append(caption, place);
    container.append(figure);
    const limits = (spec.limits || []).flatMap(([parameter, side]) => [1, -1].map((sign) => ({parameter, side, sign})));
    let values = {};
    const axis = (scale, side) => ({scale, side, stroke: () => mrc.colour('--soft'), size: side === 1 ? 44 : 52, font: '12px system-ui',
      grid: {show: side === 3, stroke: () => mrc.colour('--faint'), width: 1}, ticks: {show: false},
      values: (_, ticks) => ticks.map((tick) => tick === null ? '' : mrc.number(tick))});
    const plot = new uPlot({
      width: Math.max(200, container.clientWidth), height: 150, legend: {show: false}, cursor: {y: false},
      padding: [8, spec.right ? 0 : 44, 0, 0],  // so that the times of all charts stand one below the other
      scales: {x: {time: false}, left: {}, right: {}},
      axes: [{stroke: () => mrc.colour('--soft'), size: 22, font: '12px system-ui', grid: {show: false}, ticks: {show: false}},
             axis('left', 3), ...(spec.right ? [axis('right', 1)] : [])],
      series: [{}, ...spec.lines.map(([, ink, side, dashed]) => ({
        scale: side || 'left', stroke: () => mrc.colour(ink), width: 1.5, dash: dashed ? [5, 4] : undefined,
        points: {show: false}})),
      ...limits.map(({side}) => ({scale: side || 'left', stroke: () => mrc.colour('--warn'), width: 1, dash: [2, 3],
                                  points: {show: false}}))],
    }, [[], ...spec.lines.map(() => []), ...limits.map(() => [])], place);
    new ResizeObserver(() => plot.setSize({width: Math.max(200, container.clientWidth), height: 150})).observe(container);
    const number = (value) => Number.isFinite(value) ? value : null;
    return {
      figure,
      setLimits(given) { values = given; },
      draw(rows) {
        if (spec.only) figure.hidden = !rows.length || !Number.isFinite(read[spec.only](rows[rows.length - 1]));
        if (figure.hidden) return;
        plot.setData([
          rows.map(read.time), ...spec.lines.map(([column]) => rows.map((row) => number(read[column](row)))),
          ...limits.map(({parameter, sign}) => {
            const value = values[parameter] > 0 ? sign * values[parameter] : null;
            return rows.map(() => value);
          })]);
      },
      redraw() { plot.redraw(false); },
    };
  }

  // Fill a container with the charts; they follow the rows that come.
  mrc.makeCharts = function (container) {
    let rows = [], charts = [], run = null, drawn = 0, read = null;
    mrc.live.on('columns', (columns) => {
      read = Object.fromEntries(columns.map((name) => [name, mrc.live.column(name)]));
      charts = CHARTS.map((spec) => makeChart(container, spec, read));
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
      if (now - drawn >= EVERY) { drawn = now; charts.forEach((chart) => chart.draw(rows)); }
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
  };
}(window.mrc));
