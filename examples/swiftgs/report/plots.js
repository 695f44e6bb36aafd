// SPDX-License-Identifier: Apache-2.0
'use strict';

// Specifications for Vega from the records of stats.js. `look` is {width}, and a `title` where no
// heading is near; a plot's height follows from what it shows. Marks that stand for measurements
// have names, which Vega makes classes.
const plots = (() => {
  const {inOrder, theme} = style;

  /// What all plots share.
  function base(look, description, height) {
    const font = 'system-ui, sans-serif';
    const title = {text: look.title, anchor: 'start', color: theme.text, font, fontSize: 14, offset: 12};
    const text = {labelColor: theme.quiet, titleColor: theme.text, labelFont: font, titleFont: font};
    return {
      description, width: look.width, height, padding: look.title ? 12 : 4, background: theme.background,
      ...(look.title ? {title} : {}),
      autosize: {type: 'fit-x', contains: 'padding'},
      config: {
        axis: {...text, labelFontSize: 12, titleFontSize: 12, titleFontWeight: 600, domainColor: theme.line,
               tickColor: theme.line, gridColor: theme.line, gridOpacity: 0.7, labelLimit: 420, titlePadding: 8},
        legend: {...text, labelFontSize: 12, titleFontSize: 12, titleFontWeight: 600, labelLimit: 420,
                 columnPadding: 16, rowPadding: 3, offset: 10,
                 layout: {bottom: {direction: 'horizontal', margin: 20}}},
        text: {font},
      },
    };
  }

  /// A legend in as many columns as there is room for, `columns` at most.
  const legend = (look, columns, more) => ({
    orient: 'bottom', direction: 'vertical',
    columns: Math.min(columns, Math.max(1, Math.floor(look.width / 230))), ...more});

  /// `values` as a log axis shows them: a little room on both sides.
  function logDomain(values) {
    const low = Math.min(...values), high = Math.max(...values);
    const room = Math.max(1.05, (high / low) ** 0.04);
    return [low / room, high * room];
  }

  /// Numbers at which a log axis has a label: as many of 1 to 9 in each power of ten as there is place for.
  function logTicks([low, high], most) {
    for (const digits of [[1, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 9], [1, 2, 3, 4, 5, 6, 8], [1, 2, 3, 5], [1, 3], [1]]) {
      const ticks = [];
      for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); ++power)
        for (const digit of digits) ticks.push(Number(`${digit}e${power}`));
      const shown = ticks.filter(tick => tick >= low && tick <= high);
      if (shown.length <= most) return shown;
    }
    return undefined;
  }

  const tipOf = (record, more) => ({
    title: record.label,
    ...Object.fromEntries(stats.durations.map(name => [name, format.short(record.ms[name].median) + ' ms'])),
    PSNR: record.psnr === null ? 'not measured' : format.psnr(record.psnr) + ' dB',
    ...(record.max_abs === null ? {} : {'largest error': format.short(record.max_abs)}),
    ...(record.intersections === null ? {} : {intersections: format.count(record.intersections)}),
    ...more,
  });

  /// About `most` multiples of 1, 2 or 5 times a power of ten.
  function linearTicks(low, high, most) {
    const power = 10 ** Math.floor(Math.log10((high - low) / most));
    const step = [1, 2, 5, 10].map(digit => digit * power).find(one => (high - low) / one <= most);
    const first = Math.ceil(low / step);
    const tick = (_, i) => Number(((first + i) * step).toPrecision(12));
    return Array.from({length: Math.floor(high / step) - first + 1}, tick);
  }

  /// The PSNR axis: infinite values lie on a line of their own above all finite ones.
  function errorScale(records) {
    const finite = records.map(record => record.psnr).filter(Number.isFinite);
    const low = Math.min(...(finite.length ? finite : [0])), high = Math.max(...(finite.length ? finite : [100]));
    const room = Math.max(2, 0.06 * (high - low));
    const infinite = records.some(record => record.psnr === Infinity) ? high + 2 * room : null;
    return {domain: [low - room, infinite === null ? high + room : infinite + 0.6 * room], infinite,
            ticks: linearTicks(low - room, high + room, 8)};
  }

  /// Every record a point: time across, PSNR up. `front` is numbered in the order of the list beside the plot.
  function pareto(records, front, look) {
    const error = errorScale(records);
    const place = record => ({x: record.ms.total.median, y: record.psnr === Infinity ? error.infinite : record.psnr});
    const tip = record => tipOf(record, front.includes(record) ? {'Pareto front': 'yes'} : {});
    const values = records.map(
      record => ({...place(record), raster: record.raster, shape: record.bounds, tip: tip(record)}));
    const ends = front.map((record, i) => ({...place(record), number: String(i + 1), label: record.label}));
    const domain = logDomain(values.map(value => value.x));
    const rasters = inOrder(records.map(record => record.raster));
    const words = inOrder(records.map(record => record.bounds));
    const x = {scale: 'x', field: 'x'}, y = {scale: 'y', field: 'y'};
    const infinite = error.infinite;
    return {
      ...base(look, `Run time against PSNR of ${records.length} renderers, ${front.length} on the Pareto front`, 400),
      data: [{name: 'records', values}, {name: 'front', values: ends}],
      scales: [
        {name: 'x', type: 'log', domain, range: 'width', nice: false},
        {name: 'y', domain: error.domain, range: 'height', zero: false, nice: false},
        {name: 'colour', type: 'ordinal', domain: rasters, range: style.colours(rasters)},
        {name: 'shape', type: 'ordinal', domain: words, range: style.shapes(words)},
      ],
      axes: [
        {orient: 'bottom', scale: 'x', title: 'Frame, ms (log)', grid: true,
         values: logTicks(domain, 11), format: '~g'},
        {orient: 'left', scale: 'y', title: 'PSNR against float64, dB', grid: true, format: '~f', values: error.ticks},
        ...(infinite === null ? [] : [{orient: 'left', scale: 'y', values: [infinite], domain: false,
          encode: {labels: {update: {text: {value: '∞'}, fontSize: {value: 18}}}}}]),
      ],
      legends: [
        legend(look, 2, {fill: 'colour', title: 'rasterizer', symbolType: 'circle'}),
        legend(look, 1, {shape: 'shape', title: 'bounds', symbolFillColor: theme.quiet, symbolStrokeColor: theme.quiet}),
      ],
      marks: [
        {type: 'line', name: 'front_line', interactive: false, from: {data: 'front'},
         encode: {update: {x, y, interpolate: {value: 'step-after'}, stroke: {value: theme.quiet},
                           strokeDash: {value: [4, 3]}, strokeWidth: {value: 1.5}}}},
        {type: 'symbol', name: 'points', from: {data: 'records'},
         encode: {update: {x, y, shape: {scale: 'shape', field: 'shape'}, fill: {scale: 'colour', field: 'raster'},
                           stroke: {scale: 'colour', field: 'raster'}, fillOpacity: {value: 0.75}, size: {value: 75},
                           tooltip: {field: 'tip'}},
                  hover: {size: {value: 150}}}},
        {type: 'symbol', name: 'front_points', interactive: false, from: {data: 'front'},
         encode: {update: {x, y, fill: {value: 'transparent'}, stroke: {value: theme.mark}, strokeWidth: {value: 1.8},
                           size: {value: 190}}}},
        {type: 'text', name: 'front_numbers', interactive: false, from: {data: 'front'},
         encode: {update: {x, y, text: {field: 'number'}, dx: {value: -10}, dy: {value: -9}, align: {value: 'right'},
                           fontWeight: {value: 700}, fontSize: {value: 12}, fill: {value: theme.mark}}}},
      ],
    };
  }

  return {base, legend, logDomain, logTicks, tipOf, pareto};
})();
