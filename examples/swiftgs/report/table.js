// SPDX-License-Identifier: Apache-2.0
'use strict';

/// An element with attributes and children; what is a text becomes text.
function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith('on')) made.addEventListener(key.slice(2), value);
    else if (value === true) made.setAttribute(key, '');
    else if (value !== false && value !== null) made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

/// A table that a click on a heading sorts. `columns` are {title, value, text, number}: `value` gives what is sorted
/// by, `text` what is shown. With `filter` only rows remain that hold all words of a field, in any column.
function sortableTable({caption, columns, rows, filter = false, sort = null}) {
  let order = sort, down = false, words = [];
  const body = element('tbody'), status = element('p', {class: 'quiet', 'aria-live': 'polite'});
  const arrows = [];

  const naming = columns.findIndex(column => !column.number);  // what rows go by
  const shownOf = row => columns.map(column => column.text ? column.text(row) : String(column.value(row)));
  const lines = rows.map(row => ({row, shown: shownOf(row)}));
  for (const line of lines) line.all = line.shown.join(' ').toLowerCase();

  /// Values that are missing stand last in both directions.
  function compare(a, b) {
    const x = columns[order].value(a.row), y = columns[order].value(b.row);
    if (x === null || y === null) return (x === null) - (y === null);
    return (x < y ? -1 : x > y ? 1 : 0) * (down ? -1 : 1);
  }

  function fill() {
    const found = lines.filter(line => words.every(word => line.all.includes(word)));
    if (order !== null) found.sort(compare);
    body.replaceChildren(...found.map(({shown}) => element('tr', {}, ...shown.map(
      (text, i) => element(i === naming ? 'th' : 'td', {class: columns[i].number ? 'number' : null,
                                                        scope: i === naming ? 'row' : null}, text)))));
    status.textContent = `${found.length} rows` + (words.length ? ` with these words, ${rows.length} in all` : '');
    arrows.forEach(({heading, arrow}, i) => {
      heading.setAttribute('aria-sort', i !== order ? 'none' : down ? 'descending' : 'ascending');
      arrow.textContent = i !== order ? '' : down ? '▼' : '▲';
    });
  }

  const headings = columns.map((column, i) => {
    const arrow = element('span', {class: 'arrow', 'aria-hidden': 'true'});
    const choose = () => { down = order === i ? !down : false; order = i; fill(); };
    const heading = element('th', {scope: 'col', class: column.number ? 'number' : null},
      element('button', {type: 'button', onclick: choose}, column.title, arrow));
    arrows.push({heading, arrow});
    return heading;
  });
  const field = element('input', {type: 'search', placeholder: 'words that a row holds', oninput: event => {
    words = event.target.value.toLowerCase().split(/\s+/).filter(Boolean);
    fill();
  }});
  const head = element('thead', {}, element('tr', {}, ...headings));
  const table = element('table', {}, element('caption', {}, caption), head, body);
  fill();
  return element('div', {class: 'table'},
    ...(filter ? [element('label', {class: 'filter'}, 'Filter ', field), status] : []),
    element('div', {class: 'scroll', tabindex: '0', role: 'region', 'aria-label': caption}, table));
}
