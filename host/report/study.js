// SPDX-License-Identifier: BSD-3-Clause
// A study: statistics, one figure against one parameter, how a figure is distributed.
'use strict';

const kSvg = 'http://www.w3.org/2000/svg';

function drawing(tag, attributes = {}, ...children) {
    const made = document.createElementNS(kSvg, tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.append(...children);
    return made;
}

/** Round numbers between two, about `count` of them. */
function ticksBetween(least, largest, count) {
    const raw = (largest - least) / count;
    if (!(raw > 0)) return [least];
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map(factor => factor * power).find(one => one >= raw * 0.999);
    const ticks = [];
    for (let i = Math.ceil(least / step - 1e-9); i * step <= largest + 1e-9 * step; ++i) ticks.push(i * step);
    return ticks;
}

/** A frame with two axes. draw(x, y): adds what is in it; x and y map values to places. */
function makeChart({title, label, x, y, draw, height = 300}) {
    const width = 460, left = 66, right = 14, top = 12, bottom = 46;
    const place = (range, from, to) => value => from + (value - range.least) / (range.largest - range.least || 1) * (to - from);
    const toX = place(x, left, width - right), toY = place(y, height - bottom, top);
    const svg = drawing('svg', {viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': label, class: 'study-chart'});
    for (const tick of ticksBetween(x.least, x.largest, 5)) {
        svg.append(drawing('line', {x1: toX(tick), x2: toX(tick), y1: top, y2: height - bottom, class: 'grid'}),
                   drawing('text', {x: toX(tick), y: height - bottom + 16, 'text-anchor': 'middle'}, formatNumber(tick, 5)));
    }
    for (const tick of ticksBetween(y.least, y.largest, 5)) {
        svg.append(drawing('line', {x1: left, x2: width - right, y1: toY(tick), y2: toY(tick), class: 'grid'}),
                   drawing('text', {x: left - 8, y: toY(tick) + 4, 'text-anchor': 'end'}, formatNumber(tick, 5)));
    }
    const name = axis => (axis.unit ? `${axis.name} [${formatUnit(axis.unit)}]` : axis.name);
    svg.append(drawing('text', {x: (left + width - right) / 2, y: height - 8, 'text-anchor': 'middle', class: 'axis'}, name(x)),
               drawing('text', {x: 0, y: 0, transform: `translate(14 ${(top + height - bottom) / 2}) rotate(-90)`, 'text-anchor': 'middle', class: 'axis'}, name(y)));
    draw(svg, toX, toY);
    return element('figure', {class: 'chart'}, element('figcaption', {class: 'chart-title'}, title), svg);
}

/** Least and largest of the numbers, a little wider. */
function rangeOf(values) {
    let least = Infinity, largest = -Infinity;
    for (const value of values)
        if (Number.isFinite(value)) {
            least = Math.min(least, value);
            largest = Math.max(largest, value);
        }
    if (least > largest) return {least: 0, largest: 1};
    const margin = (0.04 * (largest - least)) || Math.abs(0.05 * largest) || 1;
    return {least: least - margin, largest: largest + margin};
}

const unitOf = column => (column.unit === '1' ? '' : column.unit);

function makeScatter(x, y) {
    let drawn = 0;
    const points = drawing('g', {class: 'points'});
    return makeChart({
        title: `${y.name} over ${x.name}`,
        label: `Every case as a point: ${y.name} over ${x.name}. The tables below have the statistics.`,
        x: {name: x.name, unit: unitOf(x), ...rangeOf(x.values)},
        y: {name: y.name, unit: unitOf(y), ...rangeOf(y.values)},
        draw: (svg, toX, toY) => {
            for (let i = 0; i < x.values.length; ++i) {
                if (!Number.isFinite(x.values[i]) || !Number.isFinite(y.values[i])) continue;
                points.append(drawing('circle', {cx: toX(x.values[i]).toFixed(1), cy: toY(y.values[i]).toFixed(1), r: x.values.length > 3000 ? 1.2 : 2.2}));
                ++drawn;
            }
            svg.append(points);
        },
    });
}

function makeHistogram(y, statistics) {
    const values = [...y.values].filter(Number.isFinite);
    const range = rangeOf(values);
    const count = Math.max(5, Math.min(40, Math.ceil(Math.sqrt(values.length))));
    const bins = new Array(count).fill(0);
    for (const value of values) ++bins[Math.min(count - 1, Math.floor((value - range.least) / (range.largest - range.least) * count))];
    const width = (range.largest - range.least) / count;
    return makeChart({
        title: `Distribution of ${y.name}`,
        label: `Number of cases over ${y.name}: ${counted(values.length, 'case', 'cases')}, mean ${withUnit(statistics?.mean, unitOf(y))}, deviation ${withUnit(statistics?.deviation, unitOf(y))}.`,
        x: {name: y.name, unit: unitOf(y), ...range},
        y: {name: 'cases', unit: '', least: 0, largest: 1.08 * Math.max(1, ...bins)},
        draw: (svg, toX, toY) => {
            bins.forEach((number, i) => svg.append(drawing('rect', {x: toX(range.least + i * width) + .5, width: Math.max(.5, toX(range.least + width) - toX(range.least) - 1), y: toY(number), height: toY(0) - toY(number), class: 'bar'})));
            for (const [key, text] of [['q05', '5 %'], ['q95', '95 %']]) {
                const at = statistics?.[key];
                if (typeof at !== 'number') continue;
                svg.append(drawing('line', {x1: toX(at), x2: toX(at), y1: toY(0), y2: 12, class: 'mark'}), drawing('text', {x: toX(at) + 3, y: 22}, text));
            }
        },
    });
}

/** Numbers without a unit in their head stand as texts: their unit is that of the row. */
const asNumber = value => (typeof value === 'string' && value !== '' && Number.isFinite(Number(value)) ? Number(value) : value === '' ? null : value);

function makeStudyTables(result) {
    const parts = [];
    const statistics = entriesOf(result.summary?.statistics);
    const numbers = ['count', 'mean', 'deviation', 'minimum', 'q05', 'q50', 'q95', 'maximum'];
    parts.push(makeTable({
        caption: `Statistics of the cases that completed, ${result.name}`,
        columns: [{name: 'figure', isText: true}, {name: 'unit', isText: true}, ...['cases', 'mean', 'deviation', 'least', '5 %', 'median', '95 %', 'largest'].map(name => ({name}))],
        rows: statistics.map(([name, one]) => [name, formatUnit(one.unit), ...numbers.map(key => one[key])]), shown: 20,
    }));
    const titles = {'sensitivities.csv': 'What each parameter does', 'correlations.csv': 'Correlation of figures and parameters', 'failures.csv': 'Cases that failed'};
    for (const table of listOf(result.tables)) {
        if (table.rows.length === 0) continue;
        const shown = {caption: `${titles[table.file] ?? table.file} (${table.file}), ${result.name}`, columns: table.columns.map(({name, unit}) => ({name, unit, isText: false})),
                       rows: table.rows.map(row => row.map(asNumber)), digits: 4};
        shown.columns.forEach((column, i) => { column.isText = shown.rows.every(row => typeof row[i] === 'string'); });
        parts.push(makeTable(shown));
        if (table.left_out > 0) parts.push(element('p', {class: 'remark'}, `${table.left_out} more rows are in ${table.file}.`));
    }
    return parts;
}

function makeStudy(result) {
    const columns = listOf(result.study?.columns).map(column => ({...column, values: decodeFloats(column.data)}));
    const parameters = columns.filter(column => column.is_parameter), figures = columns.filter(column => !column.is_parameter);
    const parts = [];
    if (figures.length > 0 && columns.length > 1) {
        const charts = element('div', {class: 'pair'});
        const choice = (label, among, first) => {
            const select = element('select', {}, ...among.map(column => element('option', {value: column.name}, column.name)));
            select.value = first.name;
            return {select, element: element('label', {}, label, select), get: () => among.find(column => column.name === select.value)};
        };
        const y = choice('figure', figures, figures[0]), x = choice('over', [...parameters, ...figures], parameters[0] ?? figures.at(-1));
        const draw = () => charts.replaceChildren(makeScatter(x.get(), y.get()), makeHistogram(y.get(), result.summary?.statistics?.[y.get().name]));
        for (const one of [x, y]) one.select.addEventListener('change', draw);
        draw();
        parts.push(element('div', {class: 'tools'}, y.element, x.element), charts);
        if (result.study.left_out > 0)
            parts.push(element('p', {class: 'remark'}, `The charts show every ${result.study.every}th case; the tables count all.`));
    }
    return element('div', {}, ...parts, ...makeStudyTables(result));
}
