// SPDX-License-Identifier: BSD-3-Clause
// What measured data say of a model: the verdict first, then values with their intervals, explanations, noise.
'use strict';

const isVerdict = result => ['identify', 'diagnose', 'sensitivity', 'optimise'].includes(result.kind);

function verdictStatus(result) {
    const s = result.summary ?? {};
    if (result.kind === 'sensitivity' || result.kind === 'optimise') return {text: 'Completed', level: 'good'};
    const isSure = s.fit?.explained !== false && !s.underdetermined && (result.kind === 'diagnose' || listOf(s.solutions).length === 1);
    const warnings = listOf(s.warnings).length;
    return isSure ? {text: warnings > 0 ? `Completed, ${counted(warnings, 'warning or note', 'warnings or notes')}` : 'Completed', level: warnings > 0 ? 'warn' : 'good'}
                  : {text: 'Read the verdict', level: 'warn'};
}

/** Values as dots with their intervals, as multiples of the file's. rows: {name, value, low, high, reference}. */
function makeIntervals(title, rows) {
    const known = rows.filter(row => Number.isFinite(row.value) && row.reference);
    if (known.length === 0) return null;
    const width = 460, edge = 150, right = 14, step = 24, top = 8, height = top + step * known.length + 46;
    const of = (row, value) => value / row.reference;
    const range = rangeOf([1, ...known.flatMap(row => [of(row, row.value), row.low == null ? NaN : of(row, row.low), row.high == null ? NaN : of(row, row.high)])]);
    const toX = value => edge + (Math.min(Math.max(value, range.least), range.largest) - range.least) / (range.largest - range.least) * (width - edge - right);
    const svg = drawing('svg', {viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': title, class: 'study-chart'});
    for (const tick of ticksBetween(range.least, range.largest, 5))
        svg.append(drawing('line', {x1: toX(tick), x2: toX(tick), y1: top, y2: height - 46, class: 'grid'}),
                   drawing('text', {x: toX(tick), y: height - 30, 'text-anchor': 'middle'}, formatNumber(tick, 4)));
    svg.append(drawing('line', {x1: toX(1), x2: toX(1), y1: top, y2: height - 46, class: 'mark'}),
               drawing('text', {x: (edge + width - right) / 2, y: height - 8, 'text-anchor': 'middle', class: 'axis'}, 'times the value of the file, 95 %'));
    known.forEach((row, i) => {
        const y = top + (i + 0.5) * step;
        const low = row.low == null ? range.least : of(row, row.low), high = row.high == null ? range.largest : of(row, row.high);
        svg.append(drawing('text', {x: edge - 8, y: y + 4, 'text-anchor': 'end'}, row.name),
                   drawing('line', {x1: toX(low), x2: toX(high), y1: y, y2: y, class: 'whisker'}),
                   drawing('circle', {cx: toX(of(row, row.value)), cy: y, r: 4, class: 'bar'}));
    });
    return element('figure', {class: 'chart'}, element('figcaption', {class: 'chart-title'}, title), svg);
}

const limitText = (value, none) => (value == null ? none : formatNumber(value, 6));

function makeSolution(solution, title) {
    const parameters = entriesOf(solution.parameters);
    const rows = parameters.map(([name, one]) => [name, formatUnit(one.unit), one.low == null && one.high == null ? null : one.value, limitText(one.low, 'no limit'), limitText(one.high, 'no limit'), one.in_file]);
    const known = parameters.filter(([, one]) => one.low != null || one.high != null).map(([name, one]) => ({name, value: one.value, low: one.low, high: one.high, reference: one.in_file}));
    return element('div', {},
        makeTable({caption: `${title}: chi2 ${formatNumber(solution.chi2, 5)} for ${counted(solution.points, 'point', 'points')}`,
                   columns: [{name: 'sought', isText: true}, {name: 'unit', isText: true}, {name: 'value'}, {name: 'from', isText: true}, {name: 'to', isText: true}, {name: 'in the file'}], rows, shown: 30}),
        makeIntervals(title, known));
}

const joined = value => (Array.isArray(value) ? value.map(one => formatNumber(one, 5)).join(', ') : value == null ? '' : formatNumber(value, 5));

function makeCandidates(summary, name) {
    const listed = [...listOf(summary.candidates), ...listOf(summary.others)];
    const rows = listed.map((one, i) => [one.alike ? 'all alike' : listOf(one.elements).join(' with '), i < listOf(summary.candidates).length ? 'yes' : '', joined(one.factor), joined(one.low), joined(one.high), joined(one.damping_factor), one.chi2, one.delta_bic]);
    if (summary.no_change) rows.push(['no change', listOf(summary.candidates).length === 0 ? 'yes' : '', '', '', '', null, summary.no_change.chi2, summary.no_change.delta_bic]);
    return makeTable({caption: `Explanations, ${name}`,
                      columns: [{name: 'changed', isText: true}, {name: 'in the answer', isText: true}, {name: 'factor', isText: true}, {name: 'from', isText: true}, {name: 'to', isText: true}, {name: 'damping'}, {name: 'chi2'}, {name: 'BIC more'}], rows});
}

function makeVerdict(result) {
    const s = result.summary ?? {};
    const parts = [];
    if (s.verdict) parts.push(element('p', {class: 'verdict'}, s.verdict));
    if (result.kind === 'optimise') {
        parts.push(element('p', {class: 'verdict'}, `${s.goal}: ${formatNumber(s.value, 7)} ${formatUnit(s.unit)}, with the file's values ${formatNumber(s.value_in_file, 7)}. ${s.ended_there} of ${counted(s.starts, 'starting point', 'starting points')} ended there.`));
        const parameters = entriesOf(s.parameters);
        parts.push(makeTable({caption: 'Values of the optimum', columns: [{name: 'parameter', isText: true}, {name: 'value'}, {name: 'in the file'}, {name: 'end of its range', isText: true}],
                              rows: parameters.map(([name, one]) => [name, one.value, one.in_file, one.at_end_of_range ? 'yes' : ''])}));
    }
    if (!s.underdetermined) listOf(s.solutions).forEach((one, i, all) => parts.push(makeSolution(one, all.length > 1 ? `Solution ${i + 1}` : 'Values')));
    if (result.kind === 'diagnose') parts.push(makeCandidates(s, result.name));
    if (listOf(s.modes).length > 0)
        parts.push(makeTable({caption: 'Measured modes and those of the model', columns: [{name: 'measured', unit: 'Hz'}, {name: 'mode'}, {name: 'predicted', unit: 'Hz'}, {name: 'MAC'}].map((column, i) => (i === 0 ? {...column, isText: false} : column)),
                              rows: s.modes.map(one => [one.measured, one.mode, one.predicted, one.mac])}));
    if (listOf(s.data).length > 0)
        parts.push(makeTable({caption: 'Noise of the data', columns: [{name: 'data', isText: true}, {name: 'points'}, {name: 'standard deviation'}, {name: 'from', isText: true}],
                              rows: s.data.map(one => [one.name, one.points, one.noise, one.noise_from])}));
    return element('div', {}, ...parts.filter(Boolean));
}
