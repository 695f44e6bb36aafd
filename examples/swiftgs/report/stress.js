// SPDX-License-Identifier: Apache-2.0
'use strict';

// What `swiftgs stress` found, as the page shows it: a panel for each family, a curve for each renderer over the
// severities. No document is needed here.
const stress = (() => {
  /// Normalised errors up to the first are as good as float can be; from the second on digits were lost.
  const limits = [10, 100];

  /// Rows of all files. JSON has no infinity: null is one, unless the renderer failed on every seed and nothing is
  /// known.
  function rowsOf(files) {
    return files.flatMap((file, index) => file.rows.map(row => {
      const known = row.failed < row.seeds;
      const worst = value => !known ? null : value ?? Infinity;
      return {...row, file: index, severity: row.severity ?? Infinity, known,
              strict_normalised_error: worst(row.strict_normalised_error),
              normalised_error: worst(row.normalised_error), max_abs: worst(row.max_abs),
              psnr: known && row.max_abs === 0 ? Infinity : row.psnr_db ?? null};
    }));
  }

  /// Families in the order of the files: {family, label, severities, curves}. A curve is one renderer of one file with
  /// its rows in the order of severities, those that are not known left out.
  function panels(rows) {
    return [...stats.groupsOf(rows, row => row.family)].map(([family, some]) => {
      const severities = stats.distinct(some, row => row.severity).sort((a, b) => a - b);
      const groups = stats.groupsOf(some.filter(row => row.known), row => `${row.file}|${row.renderer}`);
      const curves = [...groups.values()].map(points => (
        {file: points[0].file, renderer: points[0].renderer, backend: points[0].backend, raster: points[0].raster,
         points: [...points].sort((a, b) => a.severity - b.severity)}));
      return {family, label: some[0].severity_label, severities, curves};
    });
  }

  /// Where each severity stands on a log axis: [{severity, x}]. What has no logarithm, 0 and infinity, stands a step
  /// beyond the others.
  function places(severities) {
    const finite = severities.filter(one => one > 0 && Number.isFinite(one)).map(Math.log10);
    if (!finite.length) return severities.map((severity, x) => ({severity, x}));
    const low = Math.min(...finite), high = Math.max(...finite);
    const step = finite.length > 1 ? (high - low) / (finite.length - 1) : 1;
    const x = one => one === 0 ? low - step : Number.isFinite(one) ? Math.log10(one) : high + step;
    return severities.map(severity => ({severity, x: x(severity)}));
  }

  /// As 1e10, 0.1 or ∞.
  function severityText(value) {
    if (!Number.isFinite(value)) return '∞';
    if (value === 0 || (value >= 0.01 && value < 1000)) return String(Number(value.toPrecision(3)));
    return value.toExponential(Math.log10(value) % 1 ? 1 : 0).replace('.0e', 'e').replace('e+', 'e');
  }

  return {limits, rowsOf, panels, places, severityText};
})();
