// @ts-check
// The replay of runs: robots on the plane in step with the page's clock, with buttons, a scrubber and keys.
//
//   mrc.makeReplay(element, data, clock)
//
// fills an element and shows it; `data` is what pages/replay_data.py packs. Keys: arrows move by a hundredth of the run
// (with shift by a thousandth), home and end to its ends. They work while the focus is in the element, and where nothing
// has the focus and the element is in view, so that they scroll the page elsewhere. On the plane + and − zoom and 0 shows
// all of it; where it is zoomed it can be dragged.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8, 16, 32, 64], LONGEST = 60;  // [s] that a replay takes at first, at most

  // Return the row of a run before a time, and how far the time is on the way to the next row, 0 to 1.
  function placeAt(times, time) {
    const n = mrc.indexAt(times, time), next = Math.min(n + 1, times.length - 1);
    const part = next > n ? (time - times[n]) / (times[next] - times[n]) : 0;
    return {n, next, part: Math.min(1, Math.max(0, part))};
  }

  const between = (values, {n, next, part}) => values ? values[n] + part * (values[next] - values[n]) : NaN;

  // Return a run with its columns unpacked, and its state at a time as scene.js draws it.
  function unpackRun(run, trailLength) {
    /** @type {Record<string, Float32Array>} */
    const columns = {};
    Object.entries(run.columns).forEach(([name, text]) => { columns[name] = mrc.unpack(text); });
    const {time} = columns, trail = {x: columns.x, y: columns.y, error: columns.error};
    /** @type {(now: number) => RobotState & {error?: number}} */
    const stateAt = function (now) {
      const place = placeAt(time, now), value = (name) => between(columns[name], place);
      if (!columns.x || now < time[0]) return {pose: null};
      return {
        pose: [value('x'), value('y'), value('heading')],
        wheels: [value('rightAngle'), value('leftAngle')],
        // the largest since the row before: between two rows nothing is known of their order
        torque: columns.rightTorque ? [columns.rightTorque[place.n], columns.leftTorque[place.n]] : null,
        limit: run.limit,
        trail: {...trail, from: mrc.indexAt(time, now - trailLength), to: place.n},
        error: columns.error ? columns.error[place.n] : NaN,
      };
    };
    const cartAt = (now) => {
      const place = placeAt(time, now);
      return columns.cart_x ? ['x', 'y', 'heading'].map((name) => between(columns[`cart_${name}`], place)) : null;
    };
    return {columns, stateAt, cartAt};
  }

  function makeControls(element, clock) {
    const bar = element.appendChild(mrc.element('div', 'controls'));
    const {play, bar: times} = mrc.makePlayer(clock), time = mrc.element('output', 'time');
    const speed = mrc.element('select', 'speed', '', {title: 'Simulated time per time'});
    bar.append(play, times, time, speed);
    speed.setAttribute('aria-label', 'Speed');
    SPEEDS.forEach((factor) => speed.append(new Option(`${factor} ×`, String(factor))));
    speed.addEventListener('change', () => { clock.speed = Number(speed.value); });
    clock.onChange(() => {
      time.textContent = `${clock.time.toFixed(2)} s of ${clock.end.toFixed(2)} s`;
      speed.value = String(clock.speed);
    });
    return bar;
  }

  const MOVES = {ArrowLeft: -1, ArrowRight: 1, ArrowDown: -1, ArrowUp: 1};
  document.addEventListener('keydown', (event) => {
    const target = /** @type {Element} */ (event.target), element = document.getElementById('replay'), {clock} = mrc;
    if (!element || !clock) return;
    const box = element.getBoundingClientRect();
    const inside = element.contains(target), free = target === document.body && box.bottom > 0.5 * box.height;
    if (!(inside || free) || event.ctrlKey || event.altKey || event.metaKey || target.tagName === 'SELECT') return;
    if (event.key in MOVES && (inside || !/Up|Down/.test(event.key))) {
      clock.pause();
      clock.set(clock.time + MOVES[event.key] * (clock.end - clock.start) / (event.shiftKey ? 1000 : 100));
    } else if (event.key === 'Home' || event.key === 'End') {
      clock.pause();
      clock.set(event.key === 'Home' ? clock.start : clock.end);
    } else return;
    event.preventDefault();
  });

  // Let the plane be zoomed and dragged; the first zoom is about a place that a function returns, where it knows one.
  function makeZoom(canvas, scene, controls, middle) {
    const zoom = (factor) => {
      scene.zoom(factor, middle());
      canvas.style.touchAction = scene.zoomed() ? 'none' : '';
      canvas.style.cursor = scene.zoomed() ? 'grab' : '';
    };
    for (const [text, title, factor] of /** @type {[string, string, number][]} */ ([
      ['+', 'Zoom into the plane', 1.5], ['−', 'Zoom out of the plane', 1 / 1.5]])) {
      const button = mrc.element('button', '', text, {type: 'button', title});
      button.setAttribute('aria-label', title);
      button.addEventListener('click', () => zoom(factor));
      controls.append(button);
    }
    canvas.addEventListener('keydown', (event) => {
      const factor = {'+': 1.5, '-': 1 / 1.5, 0: 0}[event.key];
      if (factor !== undefined && !event.ctrlKey) zoom(factor);
    });
    /** @type {PointerEvent | null} */
    let held = null;
    canvas.addEventListener('pointerdown', (event) => {
      if (!scene.zoomed()) return;
      held = event;
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener('pointermove', (event) => {
      if (!held) return;
      scene.pan(event.clientX - held.clientX, event.clientY - held.clientY);
      held = event;
    });
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, () => { held = null; });
  }

  mrc.makeReplay = function (element, data, clock) {
    const canvas = element.appendChild(mrc.element('canvas', '', '', {tabIndex: 0}));
    canvas.setAttribute('role', 'img');
    canvas.setAttribute('aria-label', `Replay of ${data.runs.map((run) => run.name).join(', ')}: `
      + 'space plays, arrow keys move in time');
    const runs = data.runs.map((run) => unpackRun(run, data.trail));
    const path = {x: mrc.unpack(data.path.x), y: mrc.unpack(data.path.y), closed: false};
    element.hidden = false;
    element.parentElement.classList.add('moving');
    const scene = mrc.makeScene(canvas, {robots: data.runs, path, errorScale: data.errorScale});
    runs.forEach(({columns}) => { if (columns.x) scene.fit(columns.x, columns.y); });
    const controls = makeControls(element, clock);
    let isHidden = (n) => false;
    const statesAt = (time) => runs.map((run, n) => isHidden(n) ? {pose: null} : run.stateAt(time));
    makeZoom(canvas, scene, controls, () => (statesAt(clock.time).find(({pose}) => pose) || {pose: null}).pose);
    // runs on one curve have one cart
    const cartsAt = (time) => runs.map((run) => run.cartAt(time)).filter((cart, n, all) => cart
      && all.findIndex((other) => other && Math.hypot(other[0] - cart[0], other[1] - cart[1]) < 1e-3) === n);
    clock.speed = SPEEDS.find((speed) => speed >= 1 && (clock.end - clock.start) / speed <= LONGEST) || SPEEDS.at(-1);
    clock.onChange(({time}) => scene.draw({robots: statesAt(time), carts: cartsAt(time)}));
    clock.set(clock.time);
    return {scene, runs, cartsAt,
      // Draw the robots once more, without a grid, in a canvas of some pixels.
      copyTo(small) {
        const copy = mrc.makeScene(small, {robots: data.runs, path, plain: true});
        runs.forEach(({columns}) => { if (columns.x) copy.fit(columns.x, columns.y); });
        const show = () => copy.draw({carts: cartsAt(clock.time),
                                      robots: statesAt(clock.time).map(({pose}) => ({pose}))});
        clock.onChange(show);
        show();
      },
      // Hide the runs that charts hide, with switches under the plane.
      follow(view) {
        isHidden = (n) => view.off.has(`run ${n}`);
        view.onChange((what) => { if (what === 'lines') clock.set(clock.time); });
        const legend = mrc.element('div', 'legend');
        data.runs.forEach((run, n) => legend.append(
          mrc.switchOf(view, `run ${n}`, run.name, mrc.strokeOf(view.data.runs[n])).button));
        element.append(legend);
      },
    };
  };
}(window.mrc));
