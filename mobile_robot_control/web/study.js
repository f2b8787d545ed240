// @ts-check
// The page of a study: a map of starts with values under the pointer, replays of some runs, and distributions.
//
// `study-data` is what studying/page.py packs. A run is shown by its number among those of its controller, from 1
// on; in the data indices are from 0 on, among the runs that the page has.
(function (mrc) {
  'use strict';

  const data = JSON.parse(document.getElementById('study-data').textContent);
  const host = document.querySelector('.charts[data-figure=starts]');
  const replayed = document.getElementById('replay');
  const REACH = 14;  // [px] of the pointer
  const HEADED = 500;  // runs whose headings are drawn; those of more would hide each other
  let clock = null;

  data.controllers.forEach((one) => {
    Object.keys(one.columns).forEach((name) => { one.columns[name] = mrc.unpack(one.columns[name]); });
  });

  function replay(one, run) {
    if (clock) clock.pause();
    replayed.replaceChildren();
    const found = one.replays[run];
    clock = mrc.clock = mrc.makeClock(found.start, found.end);
    replayed.append(mrc.element('h3', '', `${one.name}, ${found.runs[0].name}`));
    mrc.replay = mrc.makeReplay(replayed, found, clock);
    replayed.scrollIntoView({block: 'nearest'});
    clock.play();
  }

  function describe(one, run) {
    const {x, y, heading, success} = one.columns, values = data.metrics.map(({name, label, unit}) => {
      const value = one.columns[name][run];
      return `${label} ${Number.isFinite(value) ? mrc.withUnit(value, unit) : 'not known'}`;
    });
    return `run ${one.numbers[run]}: ${success[run] ? 'success' : 'failure'}; start ${mrc.number(x[run], 'm')}, `
      + `${mrc.number(y[run], 'm')}, ${mrc.number(heading[run], 'rad')}; ${values.slice(0, 3).join('; ')}`;
  }

  function drawMap(one) {
    const box = host.appendChild(mrc.element('div', 'chart starts')), canvas = mrc.element('canvas');
    const note = mrc.element('p', 'soft'), list = mrc.element('div', 'legend');
    box.append(mrc.element('h4', '', one.name), canvas, note, list);
    canvas.setAttribute('role', 'img');
    canvas.setAttribute('aria-label', `Where the robot started, ${one.name}`);
    const {x, y, heading, success} = one.columns;
    const reach = 1.12 * Math.max(0.05, ...data.controllers.flatMap((each) => [...each.columns.x, ...each.columns.y]
      .map(Math.abs)));
    let size = 0, under = -1;
    const place = (n) => [size / 2 * (1 + x[n] / reach), size / 2 * (1 - y[n] / reach)];

    function draw() {
      size = canvas.clientWidth;
      const ratio = window.devicePixelRatio || 1, pen = canvas.getContext('2d');
      if (!size) return;
      canvas.width = canvas.height = Math.round(size * ratio);
      pen.setTransform(ratio, 0, 0, ratio, 0, 0);
      pen.font = '12px system-ui, sans-serif';
      pen.strokeStyle = mrc.colour('--faint');
      pen.fillStyle = mrc.colour('--soft');
      const step = mrc.roundStep(reach / 3);
      for (let n = -Math.floor(reach / step); n * step < reach; n++) {
        const at = size / 2 * (1 + n * step / reach);
        pen.strokeRect(at, 0, 0, size);
        pen.strokeRect(0, at, size, 0);
        const value = String(Number((n * step).toPrecision(3))).replace('-', '−');
        if (n && at > 4 && at < size - 70) pen.fillText(value, at + 3, size - 4);
        if (n && at > 24 && at < size - 24) pen.fillText(value, 3, size - at - 3);
      }
      pen.fillText('y [m]', 3, 12);
      pen.textAlign = 'right';
      pen.fillText('x [m]', size - 3, size - 4);
      pen.textAlign = 'left';
      for (const succeeded of [1, 0]) {
        for (let n = 0; n < one.count; n++) {
          if (success[n] !== succeeded) continue;
          const [px, py] = place(n);
          pen.fillStyle = pen.strokeStyle = mrc.colour(succeeded ? '--robot-1' : '--robot-2');
          pen.beginPath();
          pen.arc(px, py, succeeded ? 2.5 : 4.5, 0, 2 * Math.PI);
          pen.fill();
          pen.beginPath();
          pen.lineWidth = 1.2;
          pen.moveTo(px, py);
          pen.lineTo(px + 12 * Math.cos(heading[n]), py - 12 * Math.sin(heading[n]));
          if (!succeeded || one.count <= HEADED || n === under) pen.stroke();
          if (String(n) in one.replays || n === under) {
            pen.strokeStyle = mrc.colour('--ink');
            pen.beginPath();
            pen.arc(px, py, 7, 0, 2 * Math.PI);
            pen.stroke();
          }
        }
      }
    }

    function nearest(event) {
      let best = -1, least = REACH;
      for (let n = 0; n < one.count; n++) {
        const [px, py] = place(n), far = Math.hypot(px - event.offsetX, py - event.offsetY);
        // where several are near, one that can be replayed
        const counted = String(n) in one.replays ? 0.6 * far : far;
        if (counted < least) { least = counted; best = n; }
      }
      return best;
    }

    const rest = `${one.count < one.of ? `${one.count} of ${one.of}` : one.count} runs; blue: success, orange: failure; ringed: can be replayed`;
    note.textContent = rest;
    canvas.addEventListener('mousemove', (event) => {
      const found = nearest(event);
      canvas.style.cursor = String(found) in one.replays ? 'pointer' : 'default';
      if (found === under) return;
      under = found;
      note.textContent = under < 0 ? rest : describe(one, under);
      draw();
    });
    canvas.addEventListener('mouseleave', () => { under = -1; note.textContent = rest; draw(); });
    canvas.addEventListener('click', (event) => {
      const found = nearest(event);
      if (String(found) in one.replays) replay(one, String(found));
    });
    const [{name: judged, label, unit}] = data.metrics;
    if (Object.keys(one.replays).length) {
      list.append(mrc.element('span', 'soft', `replays, with the distance of the start and ${label}:`));
    }
    Object.keys(one.replays).forEach((run) => {
      const away = mrc.number(Math.hypot(x[run], y[run]), 'm', 3), value = one.columns[judged][run];
      const button = mrc.element('button', '', `${success[run] ? 'median' : 'failure'} ${one.numbers[run]}: ${away}, `
        + (Number.isFinite(value) ? mrc.withUnit(value, unit) : 'not known'),
                                 {type: 'button', title: describe(one, Number(run))});
      button.addEventListener('click', () => replay(one, run));
      list.append(button);
    });
    new ResizeObserver(() => requestAnimationFrame(draw)).observe(box);
    mrc.onDark(draw);
    draw();
  }

  // Draw the share of runs that have at most a value of a metric, one line a controller.
  function drawDistribution({name, label, unit}, place) {
    const lines = data.controllers.map((one) => ({one, ...one.distributions[name]})).filter(({values}) => values.length);
    if (!lines.length) return;
    const box = place.appendChild(mrc.element('div', 'chart')), head = box.appendChild(mrc.element('div', 'head'));
    const every = lines.flatMap(({values}) => values), low = Math.min(...every), high = Math.max(...every);
    const logarithmic = low > 0 && high > 30 * low;
    const shown = mrc.element('div', 'legend'), styles = lines.map(({one}, n) => (
      {colour: one, width: 2, dash: n ? [6, 2 * n] : []}));
    const names = lines.map(({one}, n) => {
      const entry = mrc.element('span', 'switch'), text = mrc.element('span', '', one.name);
      entry.append(mrc.sample(styles[n]), text);
      shown.append(entry);
      return text;
    });
    head.append(mrc.element('h4', '', `${label}${unit ? ` [${unit}]` : ''}${logarithmic ? ', logarithmic scale' : ''}`),
                shown);
    // of the runs without a value, none has at most any
    const joined = uPlot.join(lines.map(({values, of, known}) => {
      const last = Math.max(1, values.length - 1);
      const shares = new Map();
      values.forEach((value, n) => shares.set(value, 100 * known / of * (values.length > 1 ? n / last : 1)));
      return [[...shares.keys()], [...shares.values()]];
    }));
    const axis = (more) => ({stroke: () => mrc.colour('--soft'), font: '12px system-ui, sans-serif', ticks: {show: false},
                             grid: {stroke: () => mrc.colour('--faint'), width: 1}, ...more});
    const show = (chart) => {
      const value = chart && chart.cursor.left >= 0 ? chart.posToVal(chart.cursor.left, 'x') : NaN;
      lines.forEach(({one, values, of, known}, n) => {
        const share = known / of * values.filter((each) => each <= value).length / values.length;
        names[n].textContent = Number.isFinite(value)
          ? `${one.name}: ${(100 * share).toFixed(1)} % at most ${mrc.withUnit(value, unit)}` : one.name;
      });
    };
    const plot = new uPlot({
      width: Math.max(box.clientWidth, 200), height: 180, legend: {show: false},
      cursor: {y: false, points: {show: false}, drag: {x: true, y: false}},
      scales: {x: {time: false, distr: logarithmic ? 3 : 1}, y: {range: [0, 102]}},
      axes: [axis({size: 28}), axis({size: 52, values: (chart, ticks) => ticks.map((tick) => `${tick} %`)})],
      series: [{}, ...lines.map(({one, values}, n) => ({
        label: one.name, width: 2, dash: styles[n].dash, stroke: () => mrc.look(one),
        points: {show: new Set(values).size < 3}}))],
      hooks: {setCursor: [show]},
    }, joined, box);
    show(null);
    new ResizeObserver(() => requestAnimationFrame(() => {
      if (box.clientWidth > 0 && box.clientWidth !== plot.width) plot.setSize({width: box.clientWidth, height: 180});
    })).observe(box);
    mrc.onDark(() => plot.redraw());
  }

  const PAGE = 50;  // rows that are shown, and that are added

  // Show all runs of a controller as a table, sorted by the head that was pressed last; a run leads to its command.
  function listRuns(place) {
    const bar = mrc.element('div', 'legend'), box = mrc.element('div', 'scroll', '', {tabIndex: 0}), table = mrc.element('table');
    const choice = mrc.element('select'), more = mrc.element('button', '', 'More', {type: 'button'});
    const command = mrc.element('pre', 'command');
    choice.setAttribute('aria-label', 'controller');
    data.controllers.forEach((one, n) => choice.append(new Option(one.name, String(n))));
    const columns = [{label: 'run', of: (one, n) => one.numbers[n]}, {label: 'success', of: (one, n) => one.columns.success[n]},
      ...['x', 'y', 'heading'].map((name) => ({label: `start ${name}`, unit: name === 'heading' ? 'rad' : 'm', name})),
      ...data.metrics].map((column) => ({of: (one, n) => (one.columns[column.name] || [])[n], unit: '', ...column}));
    let sorted = 0, falling = false, shown = PAGE;

    function show() {
      const one = data.controllers[Number(choice.value)], column = columns[sorted];
      const order = Array.from({length: one.count}, (_, n) => n).sort((a, b) => {
        const [first, second] = [column.of(one, a), column.of(one, b)];
        // what is not known is last, either way
        if (!Number.isFinite(first) || !Number.isFinite(second)) return Number(!Number.isFinite(first)) - Number(!Number.isFinite(second));
        return (falling ? second - first : first - second) || a - b;
      });
      const head = mrc.element('tr'), body = mrc.element('tbody');
      columns.forEach(({label, unit}, n) => {
        const cell = mrc.element('th', 'number'), press = mrc.element('button', '', label + (unit ? ` [${unit.replace(' ', '\u00a0')}]` : ''), {type: 'button'});
        cell.setAttribute('aria-sort', n !== sorted ? 'none' : falling ? 'descending' : 'ascending');
        press.addEventListener('click', () => {
          falling = n === sorted && !falling;
          sorted = n;
          show();
          /** @type {HTMLElement} */ (table.querySelectorAll('th button')[n]).focus();
        });
        cell.append(press);
        head.append(cell);
      });
      order.slice(0, shown).forEach((run) => {
        const row = mrc.element('tr');
        columns.forEach(({label, of}, n) => {
          const value = of(one, run), cell = mrc.element('td', 'number');
          if (n) cell.textContent = label === 'success' ? (value ? 'yes' : 'no') : mrc.number(value);
          else {
            const press = mrc.element('button', '', String(value), {type: 'button', title: 'Show the command that replays it'});
            press.setAttribute('aria-label', `the command that replays run ${value}`);
            press.addEventListener('click', () => { command.textContent = `${data.command} --only ${value}`; });
            cell.append(press);
          }
          row.append(cell);
        });
        body.append(row);
      });
      const top = mrc.element('thead');
      top.append(head);
      table.replaceChildren(top, body);
      more.hidden = shown >= one.count;
      more.textContent = `Show more than ${shown} of ${one.count}`;
    }

    choice.addEventListener('change', show);
    more.addEventListener('click', () => { shown += PAGE; show(); });
    bar.append(choice, more);
    box.append(table);
    command.setAttribute('role', 'status');
    command.textContent = 'The number of a run shows its command here.';
    place.append(bar, command, box);
    show();
  }

  host.closest('figure').classList.add('charted');
  data.controllers.forEach(drawMap);
  const listed = document.querySelector('.charts[data-figure=run-table]');
  listed.closest('figure').classList.add('charted');
  listRuns(listed);
  const place = document.querySelector('.charts[data-figure=distributions]');
  place.closest('figure').classList.add('charted');
  data.metrics.forEach((metric) => drawDistribution(metric, place));
  mrc.study = {data, replay};
}(window.mrc));
