// @ts-check
// Marks of events: dotted lines in charts of uPlot, and strokes under a bar of time.
window.mrc = window.mrc || /** @type {Mrc} */ ({});
(function (mrc) {
  'use strict';

  // Draw a line at each mark, with words where they have room: in the chart, or above it.
  mrc.drawMarks = function (plot, marks, words, above = false) {
    const {left, width, top, height} = plot.bbox, pen = plot.ctx, ratio = window.devicePixelRatio || 1;
    pen.save();
    pen.strokeStyle = pen.fillStyle = mrc.colour('--soft');
    pen.font = `${11 * ratio}px system-ui`;
    pen.textAlign = 'left';
    pen.textBaseline = 'alphabetic';
    pen.lineWidth = ratio;
    pen.setLineDash([2 * ratio, 3 * ratio]);
    let free = -Infinity;
    for (const {time, text} of marks) {
      const x = Math.round(plot.valToPos(time, 'x', true));
      if (!(x >= left && x <= left + width)) continue;
      pen.beginPath();
      pen.moveTo(x, top);
      pen.lineTo(x, top + height);
      pen.stroke();
      let label = text;
      while (label.length > 1 && pen.measureText(label).width > width) label = `${label.slice(0, -2)}…`;
      const wide = pen.measureText(label).width, at = Math.min(x + 3 * ratio, left + width - wide);
      if (words && at > free) {
        pen.fillText(label, at, top + (above ? -5 : 10) * ratio);
        free = at + wide + 6 * ratio;
      }
    }
    pen.restore();
  };

  // Put a stroke under each bar of time of the page at each mark.
  mrc.markBars = function (marks, clock) {
    for (const bar of document.querySelectorAll('.time-bar')) {
      for (const {time, text} of marks) {
        const stroke = bar.appendChild(mrc.element('i', 'mark', '', {title: `${time.toFixed(2)} s: ${text}`}));
        stroke.style.left = `${100 * (time - clock.start) / (clock.end - clock.start)}%`;
      }
    }
  };
}(window.mrc));
