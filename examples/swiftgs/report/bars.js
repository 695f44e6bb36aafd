// SPDX-License-Identifier: Apache-2.0
'use strict';

// Bars: times of stages, and speed-ups. Records and looks are as in plots.js.
const bars = (() => {
  const {base, legend, tipOf} = plots, {inOrder, theme} = style;

  /// Bands down the page with their names on an axis.
  function bands(names, {step, padding}) {
    return {height: names.length * step,
            scale: {name: 'band', type: 'band', domain: names, range: 'height', paddingInner: padding},
            axis: {orient: 'left', scale: 'band', ticks: false, domain: false, labelPadding: 6}};
  }

  /// The stages of each record, quickest first, on one axis, with the interval of the total.
  function stagesStacked(records, look) {
    const sorted = [...records].sort((a, b) => a.ms.total.median - b.ms.total.median);
    const segments = [], totals = [];
    for (const record of sorted) {
      let from = 0;
      const tip = tipOf(record, {});
      for (const stage of stats.stages) {
        const to = from + record.ms[stage].median;
        segments.push({label: record.label, stage, from, to, tip});
        from = to;
      }
      const {median, low, high} = record.ms.total;
      totals.push({label: record.label, low, high, median, text: format.short(median) + ' ms', tip});
    }
    const band = bands(sorted.map(record => record.label), {step: 20, padding: 0.25});
    const most = Math.max(...totals.map(total => Math.max(total.median, total.high ?? 0)));
    const y = {scale: 'band', field: 'label'}, height = {scale: 'band', band: 1};
    const middle = {scale: 'band', field: 'label', band: 0.5};
    return {
      ...base(look, `Times of the stages of ${records.length} renderers, quickest first`, band.height),
      data: [{name: 'of_segments', values: segments}, {name: 'of_totals', values: totals},
             {name: 'of_intervals', values: totals.filter(total => total.low !== null && total.high !== null)}],
      scales: [
        band.scale,
        {name: 'x', domain: [0, most * 1.1], range: 'width', nice: false},
        {name: 'colour', type: 'ordinal', domain: stats.stages, range: stats.stages.map(stage => theme.stages[stage])},
      ],
      axes: [{orient: 'bottom', scale: 'x', title: 'ms a frame', grid: true, tickCount: 8}, band.axis],
      legends: [legend(look, 4, {fill: 'colour', orient: 'top', symbolType: 'square'})],
      marks: [
        {type: 'rect', name: 'segments', from: {data: 'of_segments'},
         encode: {update: {x: {scale: 'x', field: 'from'}, x2: {scale: 'x', field: 'to'}, y, height,
                           fill: {scale: 'colour', field: 'stage'}, tooltip: {field: 'tip'}},
                  hover: {}}},
        {type: 'rule', name: 'intervals', interactive: false, from: {data: 'of_intervals'},
         encode: {update: {x: {scale: 'x', field: 'low'}, x2: {scale: 'x', field: 'high'}, y: middle,
                           stroke: {value: theme.mark}, strokeWidth: {value: 2.5}, strokeCap: {value: 'butt'}}}},
        {type: 'rule', name: 'medians', interactive: false, from: {data: 'of_totals'},
         encode: {update: {x: {scale: 'x', field: 'median'}, y: {...middle, offset: -5},
                           y2: {...middle, offset: 5}, stroke: {value: theme.mark},
                           strokeWidth: {value: 2}}}},
        {type: 'text', name: 'totals', interactive: false, from: {data: 'of_totals'},
         encode: {update: {x: {scale: 'x', signal: 'max(datum.median, datum.high)', offset: 6}, y: middle,
                           text: {field: 'text'}, baseline: {value: 'middle'}, fontSize: {value: 11},
                           fill: {value: theme.text}}}},
      ],
    };
  }

  /// How many times quicker than the baseline, by rasterizer and within it by sort.
  function speedups(records, baseline, look) {
    const rasters = inOrder(records.map(record => record.raster)), sorts = inOrder(records.map(record => record.sort));
    const values = records.map(record => {
      const times = stats.speedup(record, record.among, baseline);
      return {raster: record.raster, sort: record.sort, times, text: times.toFixed(2) + '×',
              tip: tipOf(record, {'speed-up': times.toFixed(3) + '×'})};
    });
    const band = bands(rasters, {step: 17 * sorts.length + 10, padding: 0.12});
    const palette = {standard: theme.quiet, early: theme.stages.raster, adaptive: theme.stages.project};
    const colours = sorts.map((sort, i) => palette[sort] ?? Object.values(theme.stages)[i % 3]);
    const most = Math.max(1, ...values.map(value => value.times));
    const bar = {scale: 'sort', field: 'sort'}, middle = {scale: 'sort', field: 'sort', band: 0.5};
    return {
      ...base(look, `Speed-up of ${records.length} renderers over ${baseline}`, band.height),
      data: [{name: 'of_bars', values}],
      scales: [
        band.scale,
        {name: 'x', domain: [0, most * 1.08], range: 'width', nice: false},
        {name: 'colour', type: 'ordinal', domain: sorts, range: colours},
      ],
      axes: [{orient: 'bottom', scale: 'x', title: 'times as quick as the baseline', grid: true, tickCount: 6},
             band.axis],
      legends: [legend(look, sorts.length, {fill: 'colour', title: 'sort', orient: 'top', columns: sorts.length,
                                            symbolType: 'square'})],
      marks: [
        {type: 'group', from: {facet: {data: 'of_bars', name: 'of_raster', groupby: 'raster'}},
         encode: {update: {y: {scale: 'band', field: 'raster'}, height: {scale: 'band', band: 1},
                           width: {signal: 'width'}}},
         signals: [{name: 'height', update: "bandwidth('band')"}],
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
         encode: {update: {x: {scale: 'x', value: 1}, y: {value: 0}, y2: {signal: 'height'},
                           stroke: {value: theme.mark},
                           strokeDash: {value: [4, 3]}}}},
      ],
    };
  }

  return {stagesStacked, speedups};
})();
