// @ts-check
// The replay of runs: robots on the plane in step with the page's clock, with buttons, a scrubber and keys.
//
//   mrc.makeReplay(element, data, clock)
//
// fills an element and shows it; `data` is what pages/replay_data.py packs. Keys: space plays and pauses, arrows
// move by a hundredth of the run (with shift by a thousandth), home and end to its ends. They work while the focus is
// in the element, and where nothing has the focus and the element is in view, so that they scroll the page elsewhere.
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
    const play = mrc.element('button', 'play', '', {type: 'button'}), time = mrc.element('output', 'time');
    const scrubber = mrc.element('input', '', '', {type: 'range', min: clock.start, max: clock.end, step: 'any'});
    const speed = mrc.element('select', 'speed', '', {title: 'Simulated time per time'});
    bar.append(play, scrubber, time, speed);
    scrubber.setAttribute('aria-label', 'Time');
    speed.setAttribute('aria-label', 'Speed');
    SPEEDS.forEach((factor) => speed.append(new Option(`${factor} ×`, String(factor))));
    play.addEventListener('click', clock.toggle);
    scrubber.addEventListener('input', () => {
      const asked = Number(scrubber.value);  // pausing shows the present time
      clock.pause();
      clock.set(asked);
    });
    speed.addEventListener('change', () => { clock.speed = Number(speed.value); });
    clock.onChange(() => {
      play.textContent = clock.playing ? '❚❚ Pause' : '► Play';
      scrubber.value = clock.time;
      const shown = `${clock.time.toFixed(2)} s`;
      scrubber.setAttribute('aria-valuetext', shown);
      time.textContent = `${shown} of ${clock.end.toFixed(2)} s`;
      speed.value = String(clock.speed);
    });
  }

  function listenToKeys(element, clock) {
    const length = clock.end - clock.start;
    const moves = {ArrowLeft: -1, ArrowRight: 1, ArrowDown: -1, ArrowUp: 1};
    document.addEventListener('keydown', (event) => {
      const target = /** @type {Element} */ (event.target), box = element.getBoundingClientRect();
      const inside = element.contains(target), free = target === document.body && box.bottom > 0.5 * box.height;
      if (!(inside || free) || event.ctrlKey || event.altKey || event.metaKey || target.tagName === 'SELECT') return;
      if (event.key === ' ' && target.tagName !== 'BUTTON') clock.toggle();
      else if (event.key in moves && (inside || !/Up|Down/.test(event.key))) {
        clock.pause();
        clock.set(clock.time + moves[event.key] * length / (event.shiftKey ? 1000 : 100));
      } else if (event.key === 'Home' || event.key === 'End') {
        clock.pause();
        clock.set(event.key === 'Home' ? clock.start : clock.end);
      } else return;
      event.preventDefault();
    });
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
    makeControls(element, clock);
    listenToKeys(element, clock);
    // runs on one curve have one cart
    const cartsAt = (time) => runs.map((run) => run.cartAt(time)).filter((cart, n, all) => cart
      && all.findIndex((other) => other && Math.hypot(other[0] - cart[0], other[1] - cart[1]) < 1e-3) === n);
    clock.speed = SPEEDS.find((speed) => speed >= 1 && (clock.end - clock.start) / speed <= LONGEST) || SPEEDS.at(-1);
    clock.onChange(({time}) => scene.draw({robots: runs.map((run) => run.stateAt(time)), carts: cartsAt(time)}));
    clock.set(clock.time);
    return {scene, runs, cartsAt};
  };
}(window.mrc));
