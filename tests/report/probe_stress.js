// SPDX-License-Identifier: Apache-2.0

// What a page of `swiftgs stress` shows, as a reader of the page sees it.
const facts = {};
const all = (selector, root = document) => [...root.querySelectorAll(selector)];
const shown = selector => all(selector).some(node => !node.closest('[hidden]'));
const heightOf = node => Math.round(Number(node.getAttribute('transform').match(/,([-\d.]+)\)/)[1]));

const [fault] = all('#fault');
facts.shown = ['pareto', 'stages', 'speedups', 'scaling', 'stress', 'images', 'tables'].filter(id => shown(`#${id}`));
facts.names = all('#stress .names text').map(text => text.textContent);
facts.points = all('#stress .points path').length;
facts.curves = all('#stress .curves path').length;
const [panel] = all('#stress .points').map(points => points.parentElement);
facts.rules = all(':scope > .mark-rule line', panel).map(heightOf);
const marks = all('.points path', panel).map(path => ({ratio: path.__data__.datum.tip['strict normalised error'], height: heightOf(path)}));
const heightAt = ratio => marks.find(mark => mark.ratio === ratio)?.height;
facts.heights = {10: heightAt('10.0'), 100: heightAt('100'), infinite: heightAt('∞')};
facts.ticks = all('.role-axis[aria-label^="X-axis"] .role-axis-label text', panel).map(text => text.textContent);
facts.backends = all('#stress .role-legend').pop() ? all('.role-legend-label text', all('#stress .role-legend').pop())
  .map(text => text.textContent) : [];
facts.note = document.querySelector('#stress .note').textContent;
facts.rows = all('#stress tbody tr').length;

const choice = all('#stress select').pop();
choice.value = 'cpu';
choice.dispatchEvent(new Event('change'));
setTimeout(() => {
  facts.of_one_backend = all('#stress .points path').length / 2;
  facts.fault = fault.hidden ? '' : fault.textContent;
  tell(facts);
}, 500);
