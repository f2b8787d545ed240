// @ts-check
// The control surface of the fuzzy law, with a dot where the robot is on it.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  const LEFT = 46, BELOW = 34, RIGHT = 8, ABOVE = 8;

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
      pen.fillStyle = mrc.colour('--soft');
      pen.textAlign = 'right';
      ['π', '0', '-π'].forEach((text, n) => pen.fillText(text, LEFT - 6, ABOVE + 0.5 * n * high + 4));
      pen.textAlign = 'left';
      pen.fillText('bearing [rad]', LEFT + 4, ABOVE + 14);
      pen.fillText('0', LEFT, height - BELOW + 14);
      pen.textAlign = 'right';
      pen.fillText(`distance ${numbers.farthest} m`, width - RIGHT, height - BELOW + 14);
      pen.textAlign = 'left';
      const unit = shown === 'linear' ? 'm/s' : 'rad/s';
      pen.fillText(`orange: −${most.toFixed(2)} ${unit}, blue: +${most.toFixed(2)} ${unit}`, LEFT,
                   height - 4);
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
