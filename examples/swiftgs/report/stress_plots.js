// SPDX-License-Identifier: Apache-2.0
'use strict';

// Small multiples of what stress.js gives: severity across on a log axis, normalised or largest error up.
const stressPlots = (() => {
  /// Quantities of a panel. What is below `floor` is drawn there, what is above `most` of a panel's domain there.
  const normalised = {
    title: 'strict normalised error', value: row => row.strict_normalised_error, rules: stress.limits,
    domain: values => [0.01, Math.max(300, ...values.filter(Number.isFinite).map(value => 1.5 * value))],
  };
  const error = {
    title: 'largest error', value: row => row.max_abs, rules: [],
    domain: values => {
      const shown = values.filter(value => Number.isFinite(value) && value > 0);
      if (!shown.length) return [1e-8, 1];
      const low = Math.min(...shown), high = Math.max(...shown);
      return [low / 2, Math.max(2 * high, 10 * low)];
    },
  };

  const dashes = [[1, 0], [5, 3], [2, 3], [8, 3, 2, 3]];
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

  /// One panel as a group of Vega at `box`, {x, y, width, height}. `sharedDomain` where all have the same axis.
  function panel(one, quantity, box, sharedDomain, line, look) {
    const {theme} = look, places = stress.places(one.severities);
    const all = one.curves.flatMap(curve => curve.points.map(quantity.value));
    const [low, high] = sharedDomain ?? quantity.domain(all);
    const at = new Map(places.map(place => [place.severity, place.x]));
    const values = one.curves.flatMap(curve => curve.points.map(row => (
      {line: line(curve), raster: curve.raster, place: at.get(row.severity), family: row.family,
       y: Math.min(high, Math.max(low, quantity.value(row))), tip: tipOf(row)})));
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
          x: {value: 0}, y: {value: -8}, text: {value: `${one.family}: ${quantity.title}`}, fontSize: {value: 12},
          fontWeight: {value: 600}, fill: {value: theme.text}}}},
        ...quantity.rules.map(limit => (
          {type: 'rule', interactive: false, encode: {update: {
            x: {value: 0}, x2: {value: width}, y: {scale: 'y', value: limit}, stroke: {value: theme.mark},
            strokeDash: {value: [4, 3]}, strokeWidth: {value: 1}}}})),
        {type: 'group', from: {facet: {data: 'values', name: 'curve', groupby: ['line', 'raster']}}, marks: [
          {type: 'line', name: 'curves', interactive: false, from: {data: 'curve'},
           encode: {update: {x, y, stroke: colour, strokeDash: {scale: 'dash', field: 'line'},
                             strokeWidth: {value: 1.6}}}}]},
        {type: 'symbol', name: 'points', from: {data: 'values'}, aria: !look.title,  // a figure has none to ask
         encode: {update: {x, y, fill: colour, shape: {value: look.title ? 'square' : 'circle'},
                           size: {value: look.title ? 16 : 22}, tooltip: {field: 'tip'}},
                  hover: {size: {value: 70}}}},
      ],
    };
  }

  /// Panels of each family side by side in as many columns as fit, one of each of `quantities`. `line` names what
  /// dashes tell apart.
  function grid(list, quantities, most, line, look) {
    const {theme} = look, least = 250;
    const whole = Math.max(1, Math.min(most, Math.floor(look.width / least)));
    const columns = whole >= quantities.length ? whole - whole % quantities.length : whole;
    const box = {width: Math.floor((look.width - 8) / columns), height: 190};
    const cells = list.flatMap(one => quantities.map(quantity => ({one, quantity})));
    const curves = list.flatMap(one => one.curves);
    const rasters = style.inOrder(curves.map(curve => curve.raster)), lines = style.inOrder(curves.map(line));
    const errors = list.flatMap(one => one.curves.flatMap(curve => curve.points.map(normalised.value)));
    const shared = normalised.domain(errors);
    return {
      ...plots.base(look,
                    `Errors of ${rasters.length} rasterizers on ${list.length} families of hard frames`,
                    box.height * Math.ceil(cells.length / columns)),
      scales: [
        {name: 'colour', type: 'ordinal', domain: rasters, range: style.colours(rasters, theme)},
        {name: 'dash', type: 'ordinal', domain: lines, range: lines.map((_, i) => dashes[i % dashes.length])},
      ],
      legends: [
        plots.legend(look, 3, {stroke: 'colour', title: 'rasterizer', orient: 'top', symbolType: 'stroke',
                               symbolStrokeWidth: 3}),
        ...(lines.length > 1 ? [plots.legend(look, 1, {strokeDash: 'dash', title: 'backend', orient: 'top',
                                                       symbolType: 'stroke',
                                                       symbolStrokeColor: theme.quiet, symbolStrokeWidth: 2})] : []),
      ],
      marks: cells.map(({one, quantity}, i) => panel(
        one, quantity, {...box, x: i % columns * box.width, y: Math.floor(i / columns) * box.height},
        quantity === normalised ? shared : null, line, look)),
    };
  }

  return {
    pairs: (list, line, look) => grid(list, [normalised, error], 2, line, look),
    normalised: (list, line, look) => grid(list, [normalised], 4, line, look),
  };
})();
