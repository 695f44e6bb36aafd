// SPDX-License-Identifier: Apache-2.0

// What a page of `swiftgs report` shows, as a reader of the page sees it: from what was drawn, not from the data.
const facts = {};
const all = (selector, root = document) => [...root.querySelectorAll(selector)];
const column = (table, index) => all(`${table} tbody tr`).map(row => row.children[index].textContent);
const texts = selector => all(selector).map(node => node.textContent);

facts.missing = document.querySelector('#missing').textContent;
facts.command = document.querySelector('.machine code').textContent;
facts.points = all('#pareto .points path').length;
facts.infinite = texts('#pareto .role-axis text').includes('∞');
facts.front = column('#pareto .list', 1);
facts.segments = all('#stages .segments path').length;
facts.speedups = all('#speedups .bars path').map(path => path.__data__.datum.times);
facts.growth = texts('#growth .role-legend-label text');
facts.errors = all('#growth .chart').pop().querySelectorAll('.points path').length;

// A click on a heading sorts, a second one the other way round.
const heading = all('#means thead th').find(node => node.textContent.startsWith('raster'));
for (let i = 0; i < 2; ++i) heading.querySelector('button').click();
facts.slowest = column('#means', 0)[0];
const field = document.querySelector('#means input');
field.value = 'STANDARD ellipse';
field.dispatchEvent(new Event('input'));
facts.filtered = column('#means', 0);

addEventListener('load', () => {
  const fault = document.querySelector('#fault');
  facts.fault = fault.hidden ? '' : fault.textContent;
  facts.asked = performance.getEntriesByType('resource').map(entry => entry.name).filter(name => !name.startsWith('data:'));
  const told = document.createElement('pre');
  told.id = 'told';
  told.textContent = encodeURIComponent(JSON.stringify(facts));
  document.body.append(told);
});
