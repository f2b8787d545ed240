// @ts-check
// A path that is drawn on the plane by pointer or keyboard: planned while it is drawn, sent to the cart, saved.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  const NEAR = 12, APART = 30;  // [px] to a point that is dragged, and between the points of a line drawn freehand
  const STEP = 0.1, LARGE = 0.5;  // [m] of an arrow key, and with Shift
  const ARROWS = {ArrowUp: [0, 1], ArrowDown: [0, -1], ArrowLeft: [-1, 0], ArrowRight: [1, 0]};
  const TURNING = 'timing.max_angular_velocity';
  const LIMITS = [['timing.max_linear_velocity', 'largest speed [m/s]', 0.5],
                  ['timing.max_wheel_torque', 'torque of a motor [N m]', 0.3],
                  [TURNING, 'largest turn rate [rad/s]', 2]];
  const BACKWARDS = 'b', ON_THE_SPOT = 't';  // marks of a point, and keys

  // Return the plan of a path as the server makes it, or null and its words.
  mrc.planPath = async (points, limits) => {
    const {good, text} = await mrc.live.ask({do: 'plan', points, limits});
    return good ? {plan: JSON.parse(text), text: ''} : {plan: null, text};
  };

  mrc.makePath = function (container, canvas) {
    /** @type {[number, number, string][]} */
    let points = [];
    let plan = null, cursor = null, held = -1, freehand = null, asked = 0, cart = {}, back = false;
    const button = (words, act) => {
      const made = mrc.element('button', '', words);
      made.addEventListener('click', act);
      return made;
    };
    const words = mrc.element('p', 'verdict');
    words.id = 'path-words';
    words.setAttribute('role', 'status');
    const draw = button('Draw', () => toggle(!canvas.classList.contains('drawing')));
    draw.setAttribute('aria-pressed', 'false');
    const undo = button('Undo', () => { points.pop(); changed(); });
    const clear = button('Clear', () => { points = []; changed(); });
    const backwards = button('Backwards', () => { back = !back; show(); });
    const turn = button('Turn here', () => turnHere());
    const send = button('Send', () => sendPath());
    const save = button('Save as CSV', () => saveCsv());
    const fields = {};
    const limitsBar = mrc.element('div', 'bar'), bar = mrc.element('div', 'bar');
    for (const [name, label, value] of LIMITS) {
      const field = mrc.element('input', '', '', {type: 'number', min: '0', step: '0.05', value: String(value)});
      field.addEventListener('change', () => { field.dataset.chosen = 'yes'; changed(); });
      const row = mrc.element('label', '', `${label} `);
      row.append(field);
      limitsBar.append(row);
      fields[name] = field;
    }
    bar.append(draw, undo, clear, backwards, turn, send, save);
    container.append(
      mrc.element('p', 'soft', 'Click points on the plane, or draw a line; drag a point to move it. With the keyboard: '
        + 'arrows move the cross (Shift: farther), Enter sets a point, Backspace takes one back. Points set with '
        + '“Backwards” (key B) are reached backwards; “Turn here” (key T) turns on the spot at the last point.'),
      limitsBar, bar, words);

    // the turn rate is a limit of a path with marks alone
    const limits = () => Object.fromEntries(LIMITS.filter(([name]) => name !== TURNING || points.some(([, , mark]) => mark))
      .map(([name]) => [name, Math.max(0, Number(fields[name].value))]));
    const add = (point) => points.push([point[0], point[1], back ? BACKWARDS : '']);

    function turnHere() {
      const last = points[points.length - 1];
      if (!last) return;
      last[2] = last[2].includes(ON_THE_SPOT) ? last[2].replace(ON_THE_SPOT, '') : last[2] + ON_THE_SPOT;
      changed();
    }

    function tell(text, bad) {
      words.textContent = text;
      words.className = bad ? 'verdict wrong' : 'verdict';
    }

    function show() {
      const drawing = canvas.classList.contains('drawing');
      undo.disabled = clear.disabled = turn.disabled = !points.length;
      backwards.setAttribute('aria-pressed', String(back));
      turn.setAttribute('aria-pressed', String(points.length > 0 && points[points.length - 1][2].includes(ON_THE_SPOT)));
      send.disabled = !plan;
      save.disabled = points.length < 2;
      mrc.stage.draw(drawing || points.length ? {
        ...(plan ? {...plan, most: Math.max(...plan.speed.map(Math.abs), 1e-6)} : {}),
        points, cursor: drawing && document.activeElement === canvas ? cursor : null} : null);
    }

    // Plan the points anew; an answer to older ones is dropped.
    async function changed() {
      plan = null;
      asked += 1;
      const mine = asked;
      show();
      if (points.length < 2) { tell(points.length ? 'A path has two points or more.' : ''); return; }
      const {plan: found, text} = await mrc.planPath(points, limits());
      if (mine !== asked) return;
      plan = found;
      if (plan) {
        const shares = Object.entries(plan.active).sort((one, other) => other[1] - one[1])
          .map(([name, share]) => `${name || 'none'} ${Math.round(100 * share)} %`);
        tell(`${mrc.number(plan.length, 'm', 3)} in ${mrc.number(plan.duration, 's', 3)}, at most `
          + `${mrc.number(Math.max(...plan.speed.map(Math.abs)), 'm/s', 3)}, slow where it is dark${
            plan.speed.some((speed) => speed < 0) ? ', dashed backwards' : ''}. Active limits: ${shares.join(', ')}.`);
      } else tell(text, true);
      show();
    }

    function toggle(on) {
      canvas.classList.toggle('drawing', on);
      draw.setAttribute('aria-pressed', String(on));
      draw.textContent = on ? 'Done' : 'Draw';
      if (on) {
        const newest = mrc.stage.newest();
        if (!cursor) cursor = newest ? [mrc.live.column('x')(newest), mrc.live.column('y')(newest)].map(rounded) : [0, 0];
        canvas.focus();
      }
      show();
    }

    async function sendPath() {
      send.disabled = true;
      const {good, text} = await mrc.live.ask({do: 'path', points, limits: limits()});
      send.disabled = !plan;
      tell(good ? text || 'The cart follows it.' : text, !good);
    }

    function saveCsv() {
      const link = mrc.element('a');
      const marked = points.some(([, , mark]) => mark) && plan, rows = marked ? plan.poses : points.map(([x, y]) => [x, y]);
      const head = marked ? '# for path.turn_back: reverse\nx,y,heading' : 'x,y';
      link.href = URL.createObjectURL(new Blob([`${[head, ...rows].join('\n')}\n`], {type: 'text/csv'}));
      link.download = 'path.csv';
      link.click();
      URL.revokeObjectURL(link.href);
    }

    const rounded = (value) => Math.round(1000 * value) / 1000;
    const onScreen = (point) => mrc.stage.toScreen(point[0], point[1]);
    function nearest(event) {
      const box = canvas.getBoundingClientRect(), at = [event.clientX - box.left, event.clientY - box.top];
      return points.findIndex((point) => {
        const [px, py] = onScreen(point);
        return Math.hypot(px - at[0], py - at[1]) <= NEAR;
      });
    }

    canvas.addEventListener('pointerdown', (event) => {
      if (!canvas.classList.contains('drawing') || !mrc.stage.newest()) return;
      event.preventDefault();
      canvas.focus();
      canvas.setPointerCapture(event.pointerId);
      held = nearest(event);
      if (held < 0) {
        add(mrc.stage.pointed(event).map(rounded));
        freehand = [event.clientX, event.clientY];
        show();
      }
    });
    canvas.addEventListener('pointermove', (event) => {
      if (held >= 0) {
        const [x, y] = mrc.stage.pointed(event).map(rounded);
        points[held] = [x, y, points[held][2]];
        show();
      }
      if (freehand && Math.hypot(event.clientX - freehand[0], event.clientY - freehand[1]) > APART) {
        add(mrc.stage.pointed(event).map(rounded));
        freehand = [event.clientX, event.clientY];
        show();
      }
    });
    const release = () => {
      if (held >= 0 || freehand) changed();
      held = -1;
      freehand = null;
    };
    canvas.addEventListener('pointerup', release);
    canvas.addEventListener('pointercancel', release);
    canvas.addEventListener('blur', show);
    canvas.addEventListener('focus', show);
    canvas.addEventListener('keydown', (event) => {
      if (!canvas.classList.contains('drawing') || event.ctrlKey || event.altKey || event.metaKey) return;
      if (ARROWS[event.key]) {
        const by = event.shiftKey ? LARGE : STEP;
        cursor = cursor.map((value, n) => rounded(value + by * ARROWS[event.key][n]));
        mrc.stage.reach(cursor);
        tell(`cross at ${cursor.join(', ')} m`);
        show();
      } else if (event.key === 'Enter') { add(cursor); changed(); } else if (event.key === 'Backspace') {
        points.pop();
        changed();
      } else if (event.key === 'Escape') toggle(false);
      else if (event.key.toLowerCase() === BACKWARDS) { back = !back; show(); }
      else if (event.key.toLowerCase() === ON_THE_SPOT) turnHere();
      else return;
      event.preventDefault();
    });

    mrc.live.on('parameters', (parameters) => {
      cart = (parameters.nodes.find((node) => node.role === 'reference_cart') || {values: {}}).values;
      for (const [name] of LIMITS) {
        const field = fields[name];
        if (!field.dataset.chosen && cart[name] > 0) field.value = String(cart[name]);
      }
      container.hidden = !('timing.max_linear_velocity' in cart);
    });
    show();
    // Forget the points, and draw no more.
    return {clear() { if (canvas.classList.contains('drawing')) toggle(false); points = []; changed(); }};
  };
}(window.mrc));
