// @ts-check
// The page of a benchmark: a press on a head sorts its table, by numbers where a column has them.
(function (mrc) {
  'use strict';

  /** @param {HTMLTableCellElement} cell */
  function keyOf(cell) {
    const data = cell.querySelector('data'), text = (cell.textContent || '').trim();
    const value = data ? Number(data.getAttribute('value')) : parseFloat(text);
    return {value, text, known: text !== '' && text !== '–'};
  }

  /** @param {HTMLTableElement} table */
  function makeSortable(table) {
    const heads = [...table.tHead.rows[0].cells], body = table.tBodies[0], rows = [...body.rows];
    heads.forEach((head, column) => {
      const press = mrc.element('button', '', '', {type: 'button'});
      press.append(...head.childNodes);
      head.append(press);
      head.setAttribute('aria-sort', 'none');
      press.addEventListener('click', () => {
        const falling = head.getAttribute('aria-sort') === 'ascending';
        heads.forEach((other) => other.setAttribute('aria-sort', 'none'));
        head.setAttribute('aria-sort', falling ? 'descending' : 'ascending');
        const keys = new Map(rows.map((row, n) => [row, {n, ...keyOf(row.cells[column])}]));
        const numbers = [...keys.values()].some(({known, value}) => known && Number.isFinite(value));
        body.append(...[...rows].sort((first, second) => {
          const a = keys.get(first), b = keys.get(second), unknown = (key) => !key.known || (numbers && !Number.isFinite(key.value));
          // what is not known is last, either way
          if (unknown(a) || unknown(b)) return Number(unknown(a)) - Number(unknown(b)) || a.n - b.n;
          const order = numbers ? a.value - b.value : a.text.localeCompare(b.text);
          return (falling ? -order : order) || a.n - b.n;
        }));
      });
    });
  }

  document.querySelectorAll('table.sortable').forEach((table) => makeSortable(/** @type {HTMLTableElement} */ (table)));
}(window.mrc));
