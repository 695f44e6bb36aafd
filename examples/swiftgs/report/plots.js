// SPDX-License-Identifier: Apache-2.0
'use strict';

// Specifications for Vega from the records of stats.js. `look` is {width, theme, narrow}, and a `title` where no
// heading is near; a plot's height follows from what it shows. Marks that stand for measurements have names, which Vega makes classes.
const plots = (() => {
  const {inOrder} = style;

  /// What all plots share.
  function base(look, description, height) {
    const {theme} = look, font = 'system-ui, sans-serif';
    const text = {labelColor: theme.quiet, titleColor: theme.text, labelFont: font, titleFont: font};
    return {
      description, width: look.width, height, padding: look.title ? 12 : 4, background: theme.background,
      ...(look.title ? {title: {text: look.title, anchor: 'start', color: theme.text, font, fontSize: 14, offset: 12}} : {}),
      autosize: {type: 'fit-x', contains: 'padding'},
      config: {
        axis: {...text, labelFontSize: 12, titleFontSize: 12, titleFontWeight: 600, domainColor: theme.line,
               tickColor: theme.line, gridColor: theme.line, gridOpacity: 0.7, labelLimit: 420, titlePadding: 8},
        legend: {...text, labelFontSize: 12, titleFontSize: 12, titleFontWeight: 600, labelLimit: 420,
                 columnPadding: 16, rowPadding: 3, offset: 10,
                 layout: {bottom: {direction: look.narrow ? 'vertical' : 'horizontal', margin: 20}}},
        text: {font},
      },
    };
  }

  /// A legend in as many columns as there is room for, `columns` at most.
  const legend = (look, columns, more) => ({
    orient: 'bottom', direction: 'vertical', columns: Math.min(columns, Math.max(1, Math.floor(look.width / 230))), ...more});

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

  const tipOf = (record, clock, more) => ({
    title: record.label,
    ...Object.fromEntries(['project', 'sort', 'raster', 'total', 'wall'].map(
      name => [name + (name === clock ? ' (shown)' : ''), format.short(record.ms[name].median) + ' ms'])),
    PSNR: record.psnr === null ? 'not measured' : format.psnr(record.psnr) + ' dB',
    ...(record.max_abs === null ? {} : {'largest error': format.short(record.max_abs)}),
    ...(record.instances === null ? {} : {instances: format.count(record.instances)}),
    ...more,
  });

  /// The PSNR axis: infinite values lie on a line of their own above all finite ones.
  function errorScale(records) {
    const finite = records.map(record => record.psnr).filter(Number.isFinite);
    const low = Math.min(...(finite.length ? finite : [0])), high = Math.max(...(finite.length ? finite : [100]));
    const room = Math.max(2, 0.06 * (high - low));
    const infinite = records.some(record => record.psnr === Infinity) ? high + 3 * room : null;
    return {domain: [low - room, infinite === null ? high + room : infinite + room], infinite};
  }

  /// Every record a point: time across, PSNR up. `front` is numbered in the order of the list beside the plot.
  function pareto(records, front, {clock, shape}, look) {
    const {theme} = look, error = errorScale(records);
    const place = record => ({x: record.ms[clock].median, y: record.psnr === Infinity ? error.infinite : record.psnr});
    const values = records.map(record => ({...place(record), raster: record.raster, shape: record[shape],
                                           tip: tipOf(record, clock, front.includes(record) ? {'Pareto front': 'yes'} : {})}));
    const ends = front.map((record, i) => ({...place(record), number: String(i + 1), label: record.label}));
    const domain = logDomain(values.map(value => value.x));
    const rasters = inOrder(records.map(record => record.raster));
    const words = inOrder(records.map(record => record[shape]));
    const x = {scale: 'x', field: 'x'}, y = {scale: 'y', field: 'y'};
    const infinite = error.infinite;
    return {
      ...base(look, `Run time against PSNR of ${records.length} renderers; ${front.length} are on the Pareto front`, 400),
      data: [{name: 'records', values}, {name: 'front', values: ends}],
      scales: [
        {name: 'x', type: 'log', domain, range: 'width', nice: false},
        {name: 'y', domain: error.domain, range: 'height', zero: false, nice: false},
        {name: 'colour', type: 'ordinal', domain: rasters, range: style.colours(rasters, theme)},
        {name: 'shape', type: 'ordinal', domain: words, range: style.shapes(words)},
      ],
      axes: [
        {orient: 'bottom', scale: 'x', title: `${clock === 'wall' ? 'Wall clock' : 'Frame'}, ms (log)`, grid: true,
         values: logTicks(domain, look.narrow ? 5 : 11), format: '~g'},
        {orient: 'left', scale: 'y', title: 'PSNR against float64, dB', grid: true, tickCount: 8,
         encode: infinite === null ? {} : {labels: {update: {opacity: {signal: `datum.value > ${infinite - 1} ? 0 : 1`}}}}},
        ...(infinite === null ? [] : [{orient: 'left', scale: 'y', values: [infinite], domain: false,
          encode: {labels: {update: {text: {value: '∞'}, fontSize: {value: 18}}}}}]),
      ],
      legends: [
        legend(look, 2, {fill: 'colour', title: 'rasterizer', symbolType: 'circle'}),
        legend(look, 1, {shape: 'shape', title: shape, symbolFillColor: theme.quiet, symbolStrokeColor: theme.quiet}),
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

  /// Bands down the page with their names: on an axis, or above the bars where there is no room beside them.
  function bands(look, names, {step, padding}) {
    const height = names.length * (look.narrow ? step + 16 : step);
    const top = look.narrow ? 16 : 0;
    const scale = {name: 'band', type: 'band', domain: names, range: 'height', paddingInner: look.narrow ? 0 : padding};
    const axes = look.narrow ? [] : [{orient: 'left', scale: 'band', ticks: false, domain: false, labelPadding: 6}];
    const labels = !look.narrow ? [] : [{type: 'text', name: 'names', interactive: false,
      from: {data: 'of_names'}, encode: {update: {
        x: {value: 2}, y: {scale: 'band', field: 'data', offset: 12}, text: {field: 'data'}, fontSize: {value: 11},
        fill: {value: look.theme.quiet}}}}];
    const data = look.narrow ? [{name: 'of_names', values: names}] : [];
    return {height, top, scale, axes, labels, data};
  }

  /// The stages of each record, quickest first, on one axis, with the interval of the total.
  function stagesStacked(records, look) {
    const sorted = [...records].sort((a, b) => a.ms.total.median - b.ms.total.median);
    const segments = [], totals = [];
    for (const record of sorted) {
      let from = 0;
      const tip = tipOf(record, null);
      const add = (stage, length) => {
        segments.push({label: record.label, stage, from, to: from + length, tip});
        from += length;
      };
      for (const stage of stats.stages) add(stage, record.ms[stage].median);
      const {median, low, high} = record.ms.total;
      if (median > 1.02 * from) add('between', median - from);
      totals.push({label: record.label, low, high, median, text: format.short(median) + ' ms', tip});
    }
    const {theme} = look, band = bands(look, sorted.map(record => record.label), {step: 20, padding: 0.25});
    const kinds = [...stats.stages, 'between'].filter(kind => segments.some(segment => segment.stage === kind));
    const most = Math.max(...totals.map(total => Math.max(total.median, total.high ?? 0)));
    const y = {scale: 'band', field: 'label', offset: band.top};
    const height = {scale: 'band', band: 1, offset: look.narrow ? -20 : 0};
    const middle = {scale: 'band', field: 'label', band: 0.5, offset: look.narrow ? 6 : 0};
    const axis = {scale: 'x', grid: true, tickCount: look.narrow ? 4 : 8};
    return {
      ...base(look, `Times of the stages of ${records.length} renderers, quickest first`, band.height),
      data: [{name: 'of_segments', values: segments}, {name: 'of_totals', values: totals},
             {name: 'of_intervals', values: totals.filter(total => total.low !== null && total.high !== null)}, ...band.data],
      scales: [
        band.scale,
        {name: 'x', domain: [0, most * (look.narrow ? 1.22 : 1.1)], range: 'width', nice: false},
        {name: 'colour', type: 'ordinal', domain: kinds, range: kinds.map(kind => theme.stages[kind])},
      ],
      axes: [{...axis, orient: 'bottom', title: 'ms a frame'}, ...band.axes],
      legends: [legend(look, 4, {fill: 'colour', orient: 'top', columns: kinds.length, symbolType: 'square'})],
      marks: [
        {type: 'rect', name: 'segments', from: {data: 'of_segments'},
         encode: {update: {x: {scale: 'x', field: 'from'}, x2: {scale: 'x', field: 'to'}, y, height,
                           fill: {scale: 'colour', field: 'stage'}, tooltip: {field: 'tip'}},
                  hover: {}}},
        {type: 'rule', name: 'intervals', interactive: false, from: {data: 'of_intervals'},
         encode: {update: {x: {scale: 'x', field: 'low'}, x2: {scale: 'x', field: 'high'}, y: middle,
                           stroke: {value: theme.mark}, strokeWidth: {value: 2.5}, strokeCap: {value: 'butt'}}}},
        {type: 'text', name: 'totals', interactive: false, from: {data: 'of_totals'},
         encode: {update: {x: {scale: 'x', signal: 'max(datum.median, datum.high)', offset: 6}, y: middle,
                           text: {field: 'text'}, baseline: {value: 'middle'}, fontSize: {value: 11},
                           fill: {value: theme.text}}}},
        ...band.labels,
      ],
    };
  }

  /// How many times quicker than the baseline, by rasterizer and within it by sort.
  function speedups(records, baseline, clock, look) {
    const {theme} = look;
    const rasters = inOrder(records.map(record => record.raster)), sorts = inOrder(records.map(record => record.sort));
    const values = records.map(record => {
      const times = stats.speedup(record, record.among, baseline, clock);
      return {raster: record.raster, sort: record.sort, times, text: times.toFixed(2) + '×',
              tip: tipOf(record, clock, {'speed-up': times.toFixed(3) + '×'})};
    });
    const band = bands(look, rasters, {step: 17 * sorts.length + 10, padding: 0.12});
    const palette = {standard: theme.stages.between, early: theme.stages.raster, adaptive: theme.stages.project};
    const colours = sorts.map((sort, i) => palette[sort] ?? Object.values(theme.stages)[i % 3]);
    const most = Math.max(1, ...values.map(value => value.times));
    const group = look.narrow ? {scale: 'band', band: 1, offset: -20} : {scale: 'band', band: 1};
    const bar = {scale: 'sort', field: 'sort'}, middle = {scale: 'sort', field: 'sort', band: 0.5};
    return {
      ...base(look, `Speed-up of ${records.length} renderers over ${baseline}`, band.height),
      data: [{name: 'of_bars', values}, ...band.data],
      scales: [
        band.scale,
        {name: 'x', domain: [0, most * (look.narrow ? 1.18 : 1.08)], range: 'width', nice: false},
        {name: 'colour', type: 'ordinal', domain: sorts, range: colours},
      ],
      axes: [{orient: 'bottom', scale: 'x', title: 'times as quick as the baseline', grid: true, tickCount: 6}, ...band.axes],
      legends: [legend(look, sorts.length, {fill: 'colour', title: 'sort', orient: 'top', columns: sorts.length, symbolType: 'square'})],
      marks: [
        {type: 'group', from: {facet: {data: 'of_bars', name: 'of_raster', groupby: 'raster'}},
         encode: {update: {y: {scale: 'band', field: 'raster', offset: band.top}, height: group, width: {signal: 'width'}}},
         signals: [{name: 'height', update: `bandwidth('band') - ${look.narrow ? 20 : 0}`}],
         scales: [{name: 'sort', type: 'band', domain: sorts, range: 'height', paddingInner: 0.12}],
         marks: [
           {type: 'rect', name: 'bars', from: {data: 'of_raster'},
            encode: {update: {x: {scale: 'x', value: 0}, x2: {scale: 'x', field: 'times'}, y: bar,
                              height: {scale: 'sort', band: 1}, fill: {scale: 'colour', field: 'sort'},
                              tooltip: {field: 'tip'}}}},
           {type: 'text', name: 'factors', interactive: false, from: {data: 'of_raster'},
            encode: {update: {x: {scale: 'x', field: 'times', offset: 5}, y: middle, text: {field: 'text'},
                              baseline: {value: 'middle'}, fontSize: {value: 11}, fill: {value: theme.text}}}},
         ]},
        {type: 'rule', interactive: false,
         encode: {update: {x: {scale: 'x', value: 1}, y: {value: 0}, y2: {signal: 'height'}, stroke: {value: theme.mark},
                           strokeDash: {value: [4, 3]}}}},
        ...band.labels,
      ],
    };
  }

  return {base, legend, logDomain, logTicks, pareto, stagesStacked, speedups};
})();
