// @ts-check
// The live page put together: buttons, keys, states, topics.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  const SPEEDS = [0.1, 0.5, 1, 2, 5, 0];  // 0: as fast as possible

  /** @type {(name: string) => any} */
  const $ = (name) => document.getElementById(name);
  let nodes = {}, recordings = [], closed = '', lasting = '', speed = NaN, time = NaN, refused = 0;

  const value = (role, name) => (nodes[role] || {})[name];
  const isPaused = () => value('plant', 'paused') === true;

  // Show a notice until it is closed, or another one comes.
  function notice(text) {
    if (text && text === closed) return;
    closed = '';
    $('notice').firstElementChild.textContent = text;
    $('notice').hidden = !text;
  }
  $('close-notice').addEventListener('click', () => {
    closed = $('notice').firstElementChild.textContent;
    $('notice').hidden = true;
  });

  // Show the words of an answer that is a refusal.
  async function ask(request) {
    const {good, text} = await mrc.live.ask(request);
    notice(good ? lasting : text);
    return {good, text};
  }

  const pause = () => ask({do: 'set', node: 'plant', values: {paused: !isPaused()}});
  $('pause').addEventListener('click', pause);
  $('step').addEventListener('click', () => ask({do: 'step'}));
  $('reset').addEventListener('click', () => reset());

  const reset = () => ask({do: 'reset'});
  function place(on) {
    $('scene').classList.toggle('placing', on);
    $('place').setAttribute('aria-pressed', on);
    $('placing').hidden = !on;
    $('hint').textContent = 'or on the plane: press where the robot is to start, pull where it is to look; arrow keys move '
      + 'it, with Shift they turn it, Enter starts';
    stage.place(on);
  }
  $('place').addEventListener('click', () => place(!$('scene').classList.contains('placing')));

  const placed = (pose) => { place(false); ask({do: 'reset', pose}); };
  const fields = ['x', 'y', 'heading'].map((name) => $('placing').elements.namedItem(name));
  const stage = mrc.makeStage($('scene'), placed, (pose) => {
    fields.forEach((field, n) => { if (document.activeElement !== field) field.value = String(Number(pose[n].toFixed(3))); });
  });
  $('placing').addEventListener('submit', (event) => {
    event.preventDefault();
    placed(fields.map((field) => Number(field.value.replace(',', '.'))));
  });
  mrc.stage = stage;
  const charts = mrc.makeCharts($('charts'), $('numbers'));
  mrc.makeParameters($('parameters'));
  mrc.path = mrc.makePath($('path'), $('scene'));
  // Show what a lesson needs alone, or all.
  mrc.fold = (on) => $('live').classList.toggle('teaching', on);
  mrc.makeLessons(mrc.live, $('lesson'), $('lessons'), charts);
  $('defaults').addEventListener('click', () => ask({do: 'defaults'}));
  $('read-law').addEventListener('click', () => ask({do: 'read_law'}));

  let curveBuilt = '';
  function showCurve(parameters) {
    const cart = parameters.nodes.find((node) => node.role === 'reference_cart');
    const entries = cart ? cart.entries.filter(({name}) => ['curve', 'scale', 'period'].includes(name)) : [];
    const structure = JSON.stringify(entries);
    if (structure !== curveBuilt) {
      curveBuilt = structure;
      $('curve').textContent = '';
      curveControls.length = 0;
      if (!entries.length) return;
      const details = mrc.element('details');
      details.append(mrc.element('summary', '', 'curve'), mrc.element('p', 'soft',
        "Another curve or scale begins a new run at the cart's start where the robot is simulated."));
      for (const entry of entries) {
        const control = mrc.makeParameter({...entry, slider: entry.name === 'period' ? entry.slider : []},
          (given) => mrc.live.ask({do: 'curve', values: {[entry.name]: given}}));
        details.append(control.row);
        curveControls.push([entry.name, control]);
      }
      $('curve').append(details);
    }
    curveControls.forEach(([name, control]) => control.show(cart.values[name]));
  }
  const curveControls = [];

  const addSpeed = (factor) => $('speed').append(new Option(factor ? `${factor} ×` : 'as fast as possible', factor));
  SPEEDS.forEach(addSpeed);
  mrc.onChoice($('speed'), () => {
    const factor = Number($('speed').value);
    ask({do: 'set', node: 'plant', values: {real_time_factor: factor}});
  });
  let entries = {};

  // Choose a law with its shipped gains; with `whole`, also in place of gains that the user has set.
  async function chooseLaw(law, whole = false) {
    const {good} = await ask({do: 'law', law, whole});
    if (!good) $('law').value = value('position_controller', 'controller_type');
  }
  mrc.onChoice($('law'), () => chooseLaw($('law').value));
  $('ship').addEventListener('click', () => chooseLaw('', true));
  $('undo-law').addEventListener('click', () => ask({do: 'undo_law'}));
  mrc.onChoice($('velocity-law'), async () => {
    const {good} = await ask({do: 'set', node: 'velocity_controller', values: {controller_type: $('velocity-law').value}});
    if (!good) $('velocity-law').value = value('velocity_controller', 'controller_type');
  });
  let gains = '';
  function showLaw({gains: found, file, before}) {
    gains = found;
    $('gains').textContent = found && `${found} gains`;
    $('gains').title = file;
    $('ship').hidden = found !== 'changed';
    $('ship').title = `all of ${file}`;
    $('undo-law').hidden = !before;
    $('undo-law').textContent = `Undo: back to ${before}`;
  }

  mrc.live.on('parameters', (parameters) => {
    nodes = Object.fromEntries(parameters.nodes.map(({role, values}) => [role, values]));
    entries = Object.fromEntries(parameters.nodes.map((node) => [node.role, node.entries]));
    $('pause').textContent = isPaused() ? 'Run' : 'Pause';
    $('pause').disabled = value('plant', 'paused') === undefined;
    $('step').disabled = !isPaused() || value('plant', 'lockstep') !== true;
    $('reset').disabled = $('place').disabled = $('pause').disabled;
    const factor = value('plant', 'real_time_factor');
    $('speed').disabled = factor === undefined || value('plant', 'lockstep') !== true;
    if (![...$('speed').options].some((option) => Number(option.value) === factor) && factor !== undefined) {
      addSpeed(factor);
    }
    if (factor !== undefined) $('speed').value = factor;
    showLaws($('law'), 'position_controller');
    showLaws($('velocity-law'), 'velocity_controller');
    showCurve(parameters);
  });

  // Offer the laws of a node, and show the running one.
  function showLaws(select, role) {
    const law = (entries[role] || []).find(({name}) => name === 'controller_type');
    if (law && law.choices.some((choice, n) => choice !== (select.options[n] || {}).value)) {
      select.textContent = '';
      law.choices.forEach((choice) => select.append(new Option(choice, choice)));
    }
    // of a node with laws that this page does not know
    const running = value(role, 'controller_type');
    if (law && ![...select.options].some((option) => option.value === running)) {
      select.append(new Option(running, running));
    }
    select.disabled = !law;
    if (law && document.activeElement !== select) select.value = running;
  }

  function showRun() {
    const parts = [];
    if (Number.isFinite(time)) parts.push(`t = ${time.toFixed(2)} s`);
    if (Number.isFinite(speed)) parts.push(`${speed.toFixed(2)} × real time`);
    if ($('live').classList.contains('teaching') && gains) {
      parts.push(`${value('position_controller', 'controller_type')}, ${gains} gains`);
    } else parts.push(`${refused} refused`);
    $('run').textContent = parts.join(' · ');
    if (performance.now() - spoken < 5000) return;
    spoken = performance.now();
    $('spoken').textContent = `${isPaused() ? 'paused' : 'running'}, ${Math.round(time)} s, ${refused} refused`;
  }
  let spoken = 0;

  let shownRun = 0;
  mrc.live.on('rows', (rows) => {
    const last = rows[rows.length - 1];
    time = mrc.live.column('time')(last);
    speed = mrc.live.column('speed')(last);
    if (performance.now() - shownRun > 200) { shownRun = performance.now(); showRun(); }
  });

  mrc.live.on('state', (state) => {
    refused = state.refused;
    recordings = state.recordings;
    showNodes(state);
    if (state.law) showLaw(state.law);
    const failed = state.nodes.filter(({text}) => text.startsWith('law failed')).map(({text}) => text);
    const now = [...failed, ...Object.values(state.ended), state.failure].filter(Boolean).join('\n');
    if (now || lasting) notice(now);
    lasting = now;
    $('name').textContent = state.name ? `${state.name} · ` : '';
    document.title = `${state.name ? `${state.name} · ` : ''}mobile_robot_control`;
    $('read-law').hidden = !state.changed_laws.length;
    $('read-law').textContent = `Read ${state.changed_laws.join(', ')} again`;
    const list = $('changes').querySelector('ol');
    list.textContent = '';
    for (const {stamp, text} of state.events) {
      list.append(mrc.element('li', '', `${stamp < 1e9 ? `t = ${stamp.toFixed(3)} s: ` : ''}${text}`));
    }
    showRecording();
    showRun();
  });

  // Anew only where something has changed: a button that is replaced loses its focus.
  let shownNodes = '';
  function showNodes(state) {
    const shown = JSON.stringify([state.nodes, state.ended, state.unreadable]);
    if (shown === shownNodes) return;
    shownNodes = shown;
    const focused = document.activeElement?.closest('#nodes [data-role]')?.getAttribute('data-role');
    $('nodes').textContent = '';
    for (const {name, role, text, good, reasons} of state.nodes) {
      const row = mrc.element('div', 'node');
      row.append(mrc.element('b', '', name), ' ', mrc.element('span', good ? 'state' : 'state bad', text));
      for (const [reason, count] of Object.entries(reasons)) row.append(mrc.element('div', 'soft', `refused ${count}: ${reason}`));
      row.dataset.role = role;
      if (role in state.ended) {
        const again = mrc.element('button', '', 'Start again', {type: 'button'});
        again.setAttribute('aria-label', `start ${role} again`);
        again.addEventListener('click', async () => { again.disabled = true; await ask({do: 'restart', node: role}); again.disabled = false; });
        row.append(' ', again);
      }
      $('nodes').append(row);
    }
    for (const [reason, count] of Object.entries(state.unreadable)) {
      $('nodes').append(mrc.element('div', 'soft', `not readable for this page, ${count}: ${reason}`));
    }
    if (!state.nodes.length) $('nodes').append(mrc.element('p', 'soft', 'no node publishes yet'));
    if (focused) $('nodes').querySelector(`[data-role="${focused}"] button`)?.focus();
  }

  function showRecording() {
    const newest = recordings.at(-1)?.state;
    $('record').textContent = newest === 'recording' ? 'Stop recording' : 'Record';
    $('record').disabled = asking || newest === 'writing';
    $('recorded').textContent = '';
    for (const {state, name, text} of [...recordings].reverse()) {
      const row = mrc.element('span', text ? 'bad' : '', {
        recording: `${name} …`, writing: `${name}: writing the report`, failed: `${name}: ${text}`,
        done: text && `${name}: ${text}`,
      }[state]);
      if (state === 'done') {
        const link = mrc.element('a', '', `report of ${name}`);
        link.href = `/recordings/${encodeURIComponent(name)}/report.html`;
        link.target = '_blank';
        row.append(' ', link);
      }
      $('recorded').append(row, ' ');
    }
  }
  let asking = false;
  $('record').addEventListener('click', async () => {
    asking = true;
    showRecording();
    await ask({do: recordings.at(-1)?.state === 'recording' ? 'finish' : 'record'});
    asking = false;
    showRecording();
  });
  $('save').addEventListener('click', async () => {
    const {good, text} = await ask({do: 'save'});
    if (!good) return;
    const link = mrc.element('a', '', text);
    link.href = `/saved/${encodeURIComponent(text)}`;
    link.download = text;
    $('saved').textContent = '';
    $('saved').append(link);
  });

  const showTopics = () => mrc.live.send({do: 'topics', shown: $('topics').open});
  $('topics').addEventListener('toggle', showTopics);
  mrc.live.on('connection', (open) => {
    if (open) showTopics(); else $('run').textContent = $('spoken').textContent = 'no connection to the server of this page: trying again';
  });
  mrc.live.on('topics', (topics) => {
    const body = $('topics').querySelector('tbody');
    body.textContent = '';
    for (const {name, type, rate, last} of topics) {
      const row = mrc.element('tr'), first = mrc.element('td');
      first.append(mrc.element('b', '', name), mrc.element('div', 'soft', type), mrc.element('div', 'last', last));
      row.append(first, mrc.element('td', 'number', rate.toFixed(1)));
      body.append(row);
    }
  });

  const disturb = (key) => ask({do: 'disturb', key});
  $('disturbances').querySelectorAll('button').forEach((button) => {
    button.addEventListener('click', () => disturb(button.dataset.key));
  });
  document.addEventListener('keydown', (event) => {
    const typing = /** @type {Element} */ (event.target).closest('input, select, textarea, button, summary, a');
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key === ' ' && !typing) { event.preventDefault(); pause(); }
    if (event.key.toLowerCase() === 'r' && !(typing && typing.matches('input, select'))) reset();
    if (event.key.startsWith('Arrow') && event.target === $('scene')
        && !['drawing', 'placing'].some((name) => $('scene').classList.contains(name))) { event.preventDefault(); disturb(event.key); }
  });
  mrc.live.begin();
}(window.mrc));
