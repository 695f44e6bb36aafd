// SPDX-License-Identifier: Apache-2.0
'use strict';

const stressSize = row => `${row.width}×${row.height}`;
const stressPolicies = row => `${row.sort}, ${row.bounds}`;

/// What dashes tell apart: backends, and files where there are several.
const stressLine = files => one => one.backend + (files.length > 1 ? `, ${files[one.file].file}` : '');

/// The part of the page about hard frames, where there are rows of them. `wanted` keeps what is chosen.
function showStress(files, wanted, chooser, setChoosers) {
  const section = document.getElementById('stress'), rows = stress.rowsOf(files);
  section.hidden = rows.length === 0;
  if (section.hidden) return;
  const draw = () => {
    let left = rows;
    const choosers = [['size', 'Image', stressSize], ['policies', 'Sort and bounds', stressPolicies],
                      ['backend', 'Backend', row => row.backend]].flatMap(([name, title, key]) => {
      const values = stats.distinct(left, key), all = name === 'backend' && values.length > 1 ? ['all'] : [];
      const chosen = [...all, ...values].includes(wanted[name]) ? wanted[name] : [...all, ...values][0];
      if (chosen !== 'all') left = left.filter(row => key(row) === chosen);
      return chooser(title, [...all, ...values].map(value => ({value, title: value})), chosen, value => {
        wanted[name] = value;
        draw();
      });
    });
    setChoosers(section.querySelector('.choosers'), choosers);
    const list = stress.panels(left);
    charts.draw(section.querySelector('.chart'), look => stressPlots.pairs(list, stressLine(files), look));
    const failed = left.filter(row => row.failed > 0);
    section.querySelector('.note').textContent = failed.length === 0 ? '' :
      `Renderers failed in ${failed.length} of ${left.length} rows, first ${failed[0].renderer}: ${failed[0].error}`;
  };
  draw();
  section.querySelector('.list').replaceChildren(stressTable(files, rows));
}

function stressTable(files, rows) {
  const number = (title, value, text = format.short) => ({title, number: true, value, text: row => text(value(row))});
  return sortableTable({caption: 'All rows of hard frames', rows, filter: true, columns: [
    {title: 'family', value: row => row.family},
    number('severity', row => row.severity, stress.severityText),
    {title: 'renderer', value: row => row.renderer},
    {title: 'size', value: row => row.width * row.height, text: stressSize, number: true},
    number('seeds', row => row.seeds, String), number('failed', row => row.failed, String),
    number('strict normalised error', row => row.strict_normalised_error),
    number('normalised error', row => row.normalised_error),
    number('largest error', row => row.max_abs), number('PSNR dB', row => row.psnr, format.psnr),
    number('left open', row => row.ambiguity ?? null),
    number('flips', row => row.flips ?? null, format.count),
    number('worst seed', row => row.worst_seed ?? null, value => value === null ? '–' : String(value)),
    ...(files.length > 1 ? [{title: 'file', value: row => files[row.file].file}] : []),
  ]});
}
