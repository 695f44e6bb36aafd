// SPDX-License-Identifier: Apache-2.0
'use strict';

// Small multiples of what stress.js gives: severity across on a log axis, strict normalised error up.
const stressPlots = (() => {
  /// Of all panels. What is below or above it is drawn at its ends.
  const domainOf = errors => [0.01, Math.max(300, ...errors.filter(Number.isFinite).map(error => 1.5 * error))];

  const margin = {left: 56, right: 10, top: 22, bottom: 40};

  /// Whole powers of ten, about `most` of them.
  function powers([low, high], most) {
    const first = Math.ceil(Math.log10(low)), last = Math.floor(Math.log10(high));
    const step = Math.max(1, Math.ceil((last - first + 1) / most));
    return Array.from({length: Math.max(0, Math.floor((last - first) / step) + 1)},
                      (_, i) => Number(`1e${first + i * step}`));
  }

  const tipOf = row => ({
    title: row.renderer, family: row.family, severity: stress.severityText(row.severity),
    'strict normalised error': format.short(row.strict_normalised_error),
    'normalised error': format.short(row.normalised_error),
    'largest error': format.short(row.max_abs),
    PSNR: format.psnr(row.psnr) + (row.psnr === null ? '' : ' dB'), 'left open': format.short(row.ambiguity),
    'worst seed': row.worst_seed, ...(row.failed ? {failed: `${row.failed} of ${row.seeds}`} : {}),
  });

  /// One panel as a group of Vega at `box`, {x, y, width, height}.
  function panel(one, box, [low, high], look) {
    const places = stress.places(one.severities);
    const at = new Map(places.map(place => [place.severity, place.x]));
    const values = one.curves.flatMap(curve => curve.points.map(row => (
      {raster: curve.raster, place: at.get(row.severity),
       y: Math.min(high, Math.max(low, row.strict_normalised_error)), tip: tipOf(row)})));
    const xs = places.map(place => place.x), room = 0.04 * (xs[xs.length - 1] - xs[0]) || 0.5;
    const width = box.width - margin.left - margin.right, height = box.height - margin.top - margin.bottom;
    const levels = powers([low, high], 6);
    const x = {scale: 'x', field: 'place'}, y = {scale: 'y', field: 'y'};
    const colour = {scale: 'colour', field: 'raster'};
    return {
      type: 'group',
      encode: {update: {x: {value: box.x + margin.left}, y: {value: box.y + margin.top}, width: {value: width},
                        height: {value: height}}},
      signals: [{name: 'width', update: String(width)}, {name: 'height', update: String(height)}],
      data: [{name: 'values', values}],
      scales: [
        {name: 'x', type: 'linear', domain: [xs[0] - room, xs[xs.length - 1] + room], range: [0, width], zero: false,
         nice: false},
        {name: 'y', type: 'log', domain: [low, high], range: [height, 0], nice: false},
        {name: 'severity', type: 'ordinal', domain: xs,
         range: places.map(place => stress.severityText(place.severity))},
        {name: 'level', type: 'ordinal', domain: levels, range: levels.map(stress.severityText)},
      ],
      axes: [
        {orient: 'bottom', scale: 'x', values: xs, title: one.label, grid: true, labelFontSize: 11, titleFontSize: 11,
         titleFontWeight: 400, titlePadding: 4, labelOverlap: true,
         encode: {labels: {update: {text: {scale: 'severity', field: 'value'}}}}},
        {orient: 'left', scale: 'y', values: levels, grid: true, labelFontSize: 11,
         encode: {labels: {update: {text: {scale: 'level', field: 'value'}}}}},
      ],
      marks: [
        {type: 'text', name: 'names', interactive: false, encode: {update: {
          x: {value: 0}, y: {value: -8}, text: {value: `${one.family}: strict normalised error`}, fontSize: {value: 12},
          fontWeight: {value: 600}, fill: {value: style.theme.text}}}},
        ...stress.limits.map(limit => (
          {type: 'rule', interactive: false, encode: {update: {
            x: {value: 0}, x2: {value: width}, y: {scale: 'y', value: limit}, stroke: {value: style.theme.mark},
            strokeDash: {value: [4, 3]}, strokeWidth: {value: 1}}}})),
        {type: 'group', from: {facet: {data: 'values', name: 'curve', groupby: 'raster'}}, marks: [
          {type: 'line', name: 'curves', interactive: false, from: {data: 'curve'},
           encode: {update: {x, y, stroke: colour, strokeWidth: {value: 1.6}}}}]},
        {type: 'symbol', name: 'points', from: {data: 'values'}, aria: !look.title,  // a figure has none to ask
         encode: {update: {x, y, fill: colour, shape: {value: look.title ? 'square' : 'circle'},
                           size: {value: look.title ? 16 : 22}, tooltip: {field: 'tip'}},
                  hover: {size: {value: 70}}}},
      ],
    };
  }

  /// Panels of each family side by side in as many columns as fit.
  function normalised(list, look) {
    const least = 250;
    const columns = Math.max(1, Math.min(4, Math.floor(look.width / least)));
    const box = {width: Math.floor((look.width - 8) / columns), height: 190};
    const curves = list.flatMap(one => one.curves), rasters = style.inOrder(curves.map(curve => curve.raster));
    const domain = domainOf(curves.flatMap(curve => curve.points.map(row => row.strict_normalised_error)));
    return {
      ...plots.base(look,
                    `Errors of ${rasters.length} rasterizers on ${list.length} families of hard frames`,
                    box.height * Math.ceil(list.length / columns)),
      scales: [{name: 'colour', type: 'ordinal', domain: rasters, range: style.colours(rasters)}],
      legends: [plots.legend(look, 3, {stroke: 'colour', title: 'rasterizer', orient: 'top', symbolType: 'stroke',
                                       symbolStrokeWidth: 3})],
      marks: list.map((one, i) => panel(
        one, {...box, x: i % columns * box.width, y: Math.floor(i / columns) * box.height}, domain, look)),
    };
  }

  return {normalised};
})();
