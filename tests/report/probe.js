// SPDX-License-Identifier: Apache-2.0

// What a page of `swiftgs report` shows, as a reader of the page sees it: from what was drawn, not from the data.
const facts = {};
const all = (selector, root = document) => [...root.querySelectorAll(selector)];
const shown = selector => all(selector).some(node => !node.closest('[hidden]'));
const placeOf = node => node.getAttribute('transform').match(/translate\(([-\d.]+),([-\d.]+)\)/).slice(1).map(Number);
const column = (table, index) => all(`${table} tbody tr`).map(row => row.children[index].textContent);

facts.fault = shown('#fault') ? document.querySelector('#fault').textContent : '';
facts.shown = ['pareto', 'stages', 'speedups', 'scaling', 'images'].filter(id => shown(`#${id}`));
facts.missing = document.querySelector('#missing').textContent;
facts.text = document.querySelector('main').textContent + document.querySelector('header').textContent;
facts.marks = Object.fromEntries(['#pareto .points path', '#pareto .front_points path', '#stages .segments path',
  '#stages .intervals line', '#speedups .bars path'].map(selector => [selector, all(selector).length]));

// PSNR of each point by its height between the ticks of the axis.
const ticks = all('#pareto .role-axis[aria-label^="Y-axis"] .role-axis-tick line')
  .map(line => ({value: line.__data__.datum.value, y: placeOf(line)[1]}));
if (ticks.length > 1) {
  const [a, b] = [ticks[0], ticks.find(tick => tick.value !== ticks[0].value)];
  facts.points = Object.fromEntries(all('#pareto .points path').map(path => [path.__data__.datum.tip.title,
    a.value + (placeOf(path)[1] - a.y) / (b.y - a.y) * (b.value - a.value)]));
}
facts.infinite = all('#pareto .role-axis text').some(text => text.textContent === '∞');
facts.front = column('#pareto .list', 1);
facts.bars = all('#speedups .bars path').map(path => path.__data__.datum.times);

facts.scaling = Object.fromEntries(all('#scaling .quantities > div').map(part => [part.id.replace('scaling-', ''), {
  points: all('.points path', part).length, legend: all('.role-legend-label text', part).map(text => text.textContent),
  dominance: part.querySelector('.dominance').textContent, exponents: all('tbody tr:first-child td', part).map(cell => cell.textContent),
}]));

// A heading sorts, by the keyboard too: it is a button. The second time the other way round.
const table = '#means', heading = all(`${table} thead th`).find(node => node.textContent.startsWith('total'));
facts.columns = all(`${table} thead th`).map(node => node.textContent);
facts.is_button = heading.querySelector('button') !== null;
document.querySelector(`${table} thead button`).click();
facts.sorted = [];
for (let i = 0; i < 2; ++i) {
  heading.querySelector('button').click();
  facts.sorted.push({aria: heading.getAttribute('aria-sort'), order: column(table, 0)});
}
const field = document.querySelector(`${table} input`);
field.value = 'STANDARD ellipse';
field.dispatchEvent(new Event('input'));
facts.filtered = column(table, 0);

const images = all('#images img');
const modes = all('#images select').pop();
if (modes) {
  modes.value = 'error';
  modes.dispatchEvent(new Event('change'));
  facts.errorLegend = shown('.error-legend');
  facts.ways = [...modes.options].map(option => option.textContent);
  modes.value = modes.options[modes.options.length - 1].value;
  modes.dispatchEvent(new Event('change'));
  facts.planeShown = all('#images img').map(image => image.alt);
}
facts.unnamed = all('select, input').filter(node => !node.closest('label')).length;
addEventListener('load', async () => {
  await Promise.all(images.map(image => image.decode()));
  facts.images = images.map(image => ({source: image.src.slice(0, 22), width: image.naturalWidth}));
  facts.fault = shown('#fault') ? document.querySelector('#fault').textContent : '';
  facts.asked = performance.getEntriesByType('resource').map(entry => entry.name).filter(name => !name.startsWith('data:'));
  tell(facts);
});
