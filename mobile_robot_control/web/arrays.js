// Numbers that packing.py packed.
window.mrc = window.mrc || {};
(function (mrc) {
  'use strict';

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
