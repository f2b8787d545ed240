// @ts-check
// What the scripts of all pages share: elements, colours, numbers as text, and numbers that packing.py packed.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  const dark = window.matchMedia('(prefers-color-scheme: dark)');

  // Return an element with a class, a text and properties; the text is never read as HTML.
  mrc.element = function (kind, name = '', text = '', properties = {}) {
    const made = document.createElement(kind);
    if (name) made.className = name;
    if (text) made.textContent = text;
    return Object.assign(made, properties);
  };

  // Call a function when a choice is made in a field, once for the pair of events that browsers send.
  mrc.onChoice = function (field, act) {
    let acted = null;
    for (const kind of ['input', 'change']) {
      field.addEventListener(kind, () => {
        if (acted === field.value) return;
        acted = field.value;
        setTimeout(() => { acted = null; });
        act();
      });
    }
  };

  // Return a colour of the page by its custom property, such as '--ink'.
  mrc.colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim() || '#888888';
  // Return the one of two colours that suits the ground.
  mrc.look = (colours) => dark.matches ? colours.dark : colours.light;
  // Call a listener whenever the page turns dark or light.
  mrc.onDark = (listener) => dark.addEventListener('change', () => listener());

  // Return a number as a text of so many digits, with its unit.
  mrc.number = function (value, unit, digits = 4) {
    if (!Number.isFinite(value)) return '–';
    return `${Number(value.toPrecision(digits))}`.replace('-', '−') + (unit ? ` ${unit}` : '');
  };

  // Return the smallest of 1, 2, 5, 10, 20, ... (and their fractions) that is at least a value.
  mrc.roundStep = function (value) {
    const decade = 10 ** Math.floor(Math.log10(value));
    return decade * [1, 2, 5, 10].find((digit) => digit * decade >= value * (1 - 1e-9));
  };

  // Return a quantity as a text of three digits with a prefix, such as '9.67 mm'.
  mrc.withUnit = function (value, unit) {
    const size = Math.abs(value);
    const [factor, prefix] = size >= 0.1 || size === 0 ? [1, ''] : size >= 1e-4 ? [1e3, 'm'] : [1e6, 'µ'];
    return `${Number((value * factor).toPrecision(3))} ${prefix}${unit}`;
  };

  // Return the Float32Array of a base64 text of little-endian 32-bit floats.
  mrc.unpack = function (text) {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const view = new DataView(bytes.buffer);
    return Float32Array.from({length: bytes.length / 4}, (_, n) => view.getFloat32(4 * n, true));
  };

  // Return the largest n with times[n] <= time; 0 before the first one. The times ascend.
  mrc.indexAt = function (times, time) {
    let low = 0, high = times.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (times[middle] <= time) low = middle + 1; else high = middle;
    }
    return Math.max(0, low - 1);
  };
}(window.mrc));
