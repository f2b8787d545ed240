// @ts-check
// The live parameters of every node, made from what the nodes say of them: unit, bounds, description, default.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  // What has a control of its own.
  const ELSEWHERE = new Set(['controller_type', 'curve', 'scale', 'period', 'real_time_factor', 'paused']);

  // Return the group of a law's gains.
  const groupOf = (law) => law === 'pi' ? 'gains' : law;

  // Return a value as a text field has it.
  const written = (value) => Array.isArray(value) ? value.map((one) => Number(Number(one).toPrecision(7))).join(', ')
    : typeof value === 'number' ? String(Number(value.toPrecision(7))) : String(value);
  const same = (one, other) => JSON.stringify(one) === JSON.stringify(other);

  // Return the value that a text stands for; a text that is none goes to the node as it is, which refuses it in words.
  function parsed(entry, text) {
    const number = (part) => {
      // 1,5 is a number, and 1,500.0 is none
      const dotted = part.trim().replace(/^([^.,]*),([^.,]*)$/, '$1.$2');
      return dotted === '' || !Number.isFinite(Number(dotted)) ? text : Number(dotted);
    };
    if (entry.kind === 'array') {
      const bare = text.replace(/[[\]]/g, ''), parts = bare.split(bare.includes(';') ? ';' : ',').map(number);
      return parts.some((part) => typeof part === 'string') ? text : parts;
    }
    return entry.kind === 'float' || entry.kind === 'int' ? number(text) : text;
  }

  // Make the control of a parameter; `send(value)` returns a promise of {good, text}.
  mrc.makeParameter = function (entry, send) {
    const row = mrc.element('div', 'parameter'), name = mrc.element('div', 'name'), words = mrc.element('div', 'words');
    words.setAttribute('role', 'alert');
    row.dataset.parameter = entry.name;
    name.append(mrc.element('b', '', entry.name), mrc.element('span', 'unit', entry.unit ? ` [${entry.unit}]` : ''));
    name.append(mrc.element('span', 'text', entry.text + (entry.allowed ? ` (${entry.allowed})` : '')));
    const back = mrc.element('button', 'back', '↩', {type: 'button'});
    let value = null, wanted = null, newest = null, busy = false, moved = -Infinity;
    const sliders = [];
    /** @type {any} */
    let field;
    if (entry.kind === 'bool') {
      field = mrc.element('input', '', '', {type: 'checkbox'});
    } else if (entry.choices.length) {
      field = mrc.element('select', 'wide');
      entry.choices.forEach((choice) => field.append(new Option(choice, choice)));
    } else {
      // an array has a slider an element
      const isArray = entry.kind === 'array';
      const wide = isArray || !entry.slider.length;
      field = mrc.element('input', wide ? 'wide' : '', '', {type: 'text', inputMode: wide ? 'text' : 'decimal'});
      (isArray ? entry.slider : entry.slider.length ? [entry.slider] : []).forEach(([min, max], n) => {
        const slider = mrc.element('input', isArray ? 'wide' : '', '', {type: 'range', min, max, step: (max - min) / 500});
        slider.setAttribute('aria-label', isArray ? `${entry.name}[${n + 1}]` : entry.name);
        sliders.push(slider);
      });
    }
    field.setAttribute('aria-label', entry.name);
    if (entry.kind === 'bool') field.style.justifySelf = 'start';
    row.append(name, ...sliders, field, back, words);
    if (entry.kind === 'bool') field.style.gridColumn = '1/3';

    // Show the value that the node has.
    function show(given) {
      value = newest = given;
      if (entry.kind === 'bool') field.checked = value === true;
      else if (document.activeElement !== field) field.value = value === null ? '' : written(value);
      // one that is moved must not jump back to what the node had a moment ago
      if (performance.now() - moved > 600) {
        sliders.forEach((slider, n) => { slider.value = Array.isArray(value) ? value[n] : value; });
      }
      const differs = entry.default !== null && value !== null && !same(value, entry.default);
      row.classList.toggle('changed', differs);
      back.hidden = !differs;
      back.setAttribute('aria-label', `${entry.name}: back to its default`);
      back.title = `back to ${entry.default === null ? '' : written(entry.default)}`;
    }

    // Send what is wanted, one at a time: the newest of a drag wins.
    async function change(given) {
      wanted = {value: given};
      newest = given;
      if (busy) return;
      busy = true;
      while (wanted) {
        const asked = wanted.value;
        wanted = null;
        const {good, text} = await send(asked);
        words.textContent = good ? '' : text;
        if (good) value = asked;
        // while a newer one waits, the slider stays where it was dragged to
        if (wanted) continue;
        if (!good) { field.blur(); moved = -Infinity; }
        show(value);
      }
      busy = false;
    }

    if (entry.kind === 'bool') field.addEventListener('change', () => change(field.checked));
    else if (entry.choices.length) field.addEventListener('change', () => change(field.value));
    else field.addEventListener('change', () => { change(parsed(entry, field.value)); });
    sliders.forEach((slider, n) => slider.addEventListener('input', () => {
      const moving = Number(slider.value);
      const asked = Array.isArray(newest) ? newest.map((other, m) => m === n ? moving : other) : moving;
      moved = performance.now();
      field.value = written(asked);
      change(asked);
    }));
    field.addEventListener('keydown', (event) => { if (event.key === 'Enter') field.blur(); });
    back.addEventListener('click', () => change(entry.default));
    return {row, show: (given) => { if (!busy) show(given); }};
  };

  // Fill a container with the parameters of all nodes, by node and group.
  mrc.makeParameters = function (container) {
    const shown = new Map(), built = new Map();

    // Make the section of a node anew; others stay as they are.
    function build({role, name, entries}) {
      const section = mrc.element('div');
      section.dataset.role = role;
      const live = entries.filter((entry) => entry.live && !ELSEWHERE.has(entry.name));
      if (live.length) section.append(mrc.element('h3', '', role));
      if (live.length && !name.endsWith(`/${role}`)) section.append(mrc.element('p', 'soft', name));
      const groups = new Map();
      for (const entry of live) {
        const group = entry.name.includes('.') ? entry.name.split('.')[0] : 'general';
        groups.set(group, [...(groups.get(group) || []), entry]);
      }
      for (const [group, members] of groups) {
        const details = mrc.element('details');
        details.dataset.group = `${role}/${group}`;
        details.append(mrc.element('summary', '', group));
        for (const entry of members) {
          const control = mrc.makeParameter(entry, (value) => mrc.live.set(role, {[entry.name]: value}));
          shown.set(`${role}.${entry.name}`, control);
          details.append(control.row);
        }
        section.append(details);
      }
      const before = container.querySelector(`[data-role="${role}"]`);
      if (before) before.remove();
      container.append(section);
    }

    const laws = {position_controller: null, velocity_controller: null};
    mrc.live.on('parameters', ({nodes}) => {
      let anew = false;
      for (const node of nodes) {
        const structure = JSON.stringify([node.name, node.entries]);
        if (structure === built.get(node.role)) continue;
        build(node);
        built.set(node.role, structure);
        anew = true;
        if (node.role in laws) laws[node.role] = null;
      }
      // in the order of the nodes, whichever answered first
      if (anew) nodes.forEach(({role}) => container.append(container.querySelector(`[data-role="${role}"]`)));
      for (const {role, values} of nodes) {
        for (const [name, value] of Object.entries(values)) {
          const control = shown.get(`${role}.${name}`);
          if (control) control.show(value);
        }
        // the gains of the law that runs stand open
        const law = laws[role], running = values.controller_type;
        if (law !== undefined && running !== undefined && running !== law) {
          container.querySelectorAll('details').forEach((one) => {
            if (one.dataset.group === `${role}/${groupOf(running)}`) one.open = true;
            else if (one.dataset.group === `${role}/${groupOf(law)}`) one.open = false;
          });
          laws[role] = running;
        }
      }
    });
  };
}(window.mrc));
