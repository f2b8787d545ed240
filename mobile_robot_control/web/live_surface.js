// @ts-check
// The control surface of the fuzzy law, with a dot where the robot is on it.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  const LEFT = 34, BELOW = 38, RIGHT = 74, ABOVE = 24, BAR = 14;  // [px] round the surface, and of the colour bar

  // Return the drawing on a canvas: {surface(numbers), choose('linear' or 'angular'), dot(distance, bearing)}.
  mrc.makeSurface = function (canvas) {
    const pen = canvas.getContext('2d');
    let most = 1, numbers = null, shown = 'linear', at = null, picture = null;
    const mixed = (part) => {
      const ends = ['--robot-2', '--tint', '--robot-1'].map((name) => {
        pen.fillStyle = mrc.colour(name);
        const hex = String(pen.fillStyle);
        return [1, 3, 5].map((n) => parseInt(hex.slice(n, n + 2), 16));
      });
      const place = part + 1, first = Math.min(1, Math.max(0, Math.floor(place)));
      return ends[first].map((value, k) => Math.round(value + (place - first) * (ends[first + 1][k] - value)));
    };

    // Paint the surface once; the dot moves on it.
    function paint() {
      const {columns, rows} = numbers, values = numbers[shown];
      most = Math.max(...values.map(Math.abs)) || 1;
      const image = new ImageData(columns, rows);
      values.forEach((value, n) => image.data.set([...mixed(value / most), 255], 4 * n));
      picture = mrc.element('canvas', '', '', {width: columns, height: rows});
      picture.getContext('2d').putImageData(image, 0, 0);
    }

    function draw() {
      const width = canvas.clientWidth, height = canvas.clientHeight, density = window.devicePixelRatio || 1;
      if (!numbers || !width) return;
      if (!picture) paint();
      canvas.width = Math.round(width * density);
      canvas.height = Math.round(height * density);
      pen.setTransform(density, 0, 0, density, 0, 0);
      const [wide, high] = [width - LEFT - RIGHT, height - BELOW - ABOVE];
      pen.drawImage(picture, LEFT, ABOVE, wide, high);
      pen.font = `12px ${getComputedStyle(canvas).fontFamily}`;
      pen.fillStyle = mrc.colour('--ink');
      const text = (words, x, y, align) => { pen.textAlign = align; pen.fillText(words, x, y); };
      ['π', '0', '−π'].forEach((words, n) => text(words, LEFT - 6, ABOVE + 0.5 * n * high + 4, 'right'));
      text('bearing [rad]', 0, 14, 'left');
      [0, 0.5, 1].forEach((part) => text(mrc.number(part * numbers.farthest, ''), LEFT + part * wide,
                                         height - BELOW + 16, part ? (part < 1 ? 'center' : 'right') : 'left'));
      text('distance [m]', LEFT + wide / 2, height - 5, 'center');
      const bar = width - RIGHT + 12;
      const shades = pen.createLinearGradient(0, ABOVE, 0, ABOVE + high);
      ['--robot-1', '--tint', '--robot-2'].forEach((name, n) => shades.addColorStop(0.5 * n, mrc.colour(name)));
      pen.fillStyle = shades;
      pen.fillRect(bar, ABOVE, BAR, high);
      pen.strokeStyle = pen.fillStyle = mrc.colour('--ink');
      pen.lineWidth = 1;
      pen.strokeRect(bar, ABOVE, BAR, high);
      [most, 0, -most].forEach((value, n) => text(mrc.number(value, '', 3), bar + BAR + 5, ABOVE + 0.5 * n * high + 4, 'left'));
      text(shown === 'linear' ? 'v [m/s]' : 'ω [rad/s]', width, 14, 'right');
      if (!at) return;
      pen.beginPath();
      pen.arc(LEFT + Math.min(1, at[0] / numbers.farthest) * wide, ABOVE + (0.5 - at[1] / (2 * Math.PI)) * high, 6, 0,
              2 * Math.PI);
      pen.fillStyle = mrc.colour('--ink');
      pen.fill();
      pen.lineWidth = 2;
      pen.strokeStyle = mrc.colour('--ground');
      pen.stroke();
    }

    new ResizeObserver(draw).observe(canvas);
    mrc.onDark(() => { picture = null; draw(); });
    return {
      surface(given) { numbers = given; picture = null; draw(); },
      choose(name) { shown = name; picture = null; draw(); },
      dot(distance, bearing) { at = [distance, bearing]; draw(); },
    };
  };
}(window.mrc));
