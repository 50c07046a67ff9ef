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

/**
 * What each parameter does to a figure, the strongest on top (a tornado). One at a time: the change from the least to the
 * largest; Morris: the size of half the range; Sobol': the share of the variance, in all (light) and alone (dark). Whiskers
 * are intervals of 95 %.
 */
function tornadoBars(table, figure) {
    const place = Object.fromEntries(table.columns.map((column, i) => [column.name, i]));
    const number = (row, name) => asNumber(row[place[name]]);
    const bars = new Map();
    for (const row of table.rows) {
        if (row[place.figure] !== figure.name) continue;
        const name = row[place.parameter];
        const bar = bars.get(name) ?? {name, low: 0, high: 0};
        if ('change' in place) {
            bar.low = Math.min(bar.low, number(row, 'change') ?? 0);
            bar.high = Math.max(bar.high, number(row, 'change') ?? 0);
        } else if ('total' in place) {
            Object.assign(bar, {high: number(row, 'total'), inner: number(row, 'first'), whisker: [number(row, 'total.low'), number(row, 'total.high')]});
        } else {
            Object.assign(bar, {high: number(row, 'size'), whisker: [number(row, 'size.low'), number(row, 'size.high')]});
        }
        bars.set(name, bar);
    }
    const isWhole = bar => Number.isFinite(bar.low) && Number.isFinite(bar.high);
    const all = [...bars.values()].filter(isWhole).sort((a, b) => (b.high - b.low) - (a.high - a.low));
    return {bars: all.slice(0, 30), left: Math.max(0, all.length - 30), isShare: 'total' in place, isChange: 'change' in place};
}

function makeTornado(table, figure) {
    const {bars, left, isShare, isChange} = tornadoBars(table, figure);
    if (bars.length === 0) return null;
    const width = 460, row = 24, edge = 130, right = 16, top = 8, height = top + row * bars.length + 46;
    const ends = bars.flatMap(bar => [bar.low, bar.high, ...(bar.whisker ?? [])]).filter(Number.isFinite);
    const range = rangeOf([0, ...ends]);
    const toX = value => edge + (value - range.least) / (range.largest - range.least) * (width - right - edge);
    const words = isShare ? 'share of the variance: in all (light), alone (dark)' : `${isChange ? 'change' : 'effect'} of ${figure.name}${unitOf(figure) ? ` [${formatUnit(unitOf(figure))}]` : ''}`;
    const svg = drawing('svg', {viewBox: `0 0 ${width} ${height}`, role: 'img', class: 'study-chart', 'aria-label': `What each parameter does to ${figure.name}, the strongest first: ${bars.map(bar => bar.name).join(', ')}.`});
    for (const tick of ticksBetween(range.least, range.largest, 5))
        svg.append(drawing('line', {x1: toX(tick), x2: toX(tick), y1: top, y2: height - 40, class: 'grid'}),
                   drawing('text', {x: toX(tick), y: height - 25, 'text-anchor': 'middle'}, formatNumber(tick, 4)));
    bars.forEach((bar, i) => {
        const y = top + row * i + 4;
        const rect = (from, to, name) => drawing('rect', {x: Math.min(toX(from), toX(to)), width: Math.max(.5, Math.abs(toX(to) - toX(from))), y, height: row - 8, class: name});
        svg.append(drawing('text', {x: edge - 8, y: y + 12, 'text-anchor': 'end', class: 'axis'}, bar.name), rect(bar.low, bar.high, bar.inner === undefined ? 'bar' : 'bar light'));
        if (Number.isFinite(bar.inner)) svg.append(rect(0, bar.inner, 'bar'));
        if (bar.whisker?.every(Number.isFinite)) svg.append(drawing('line', {x1: toX(bar.whisker[0]), x2: toX(bar.whisker[1]), y1: y + row / 2 - 4, y2: y + row / 2 - 4, class: 'whisker'}));
    });
    svg.append(drawing('text', {x: (edge + width - right) / 2, y: height - 6, 'text-anchor': 'middle', class: 'axis'}, left > 0 ? `${words}; ${left} weaker ones are in the table` : words));
    return element('figure', {class: 'chart'}, element('figcaption', {class: 'chart-title'}, `What each parameter does to ${figure.name}`), svg);
}

/** Numbers without a unit in their head stand as texts: their unit is that of the row. */
const asNumber = value => (typeof value === 'string' && value !== '' && Number.isFinite(Number(value)) ? Number(value) : value === '' ? null : value);

function makeStudyTables(result) {
    const parts = [];
    const statistics = entriesOf(result.summary?.statistics);
    const numbers = ['count', 'without', 'mean', 'deviation', 'minimum', 'q05', 'q50', 'q95', 'maximum'];
    parts.push(makeTable({
        caption: `Statistics of the cases that completed, ${result.name}`,
        columns: [{name: 'figure', isText: true}, {name: 'unit', isText: true}, ...['cases', 'cases without', 'mean', 'deviation', 'least', '5 %', 'median', '95 %', 'largest'].map(name => ({name}))],
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
        const sensitivities = listOf(result.tables).find(table => table.file === 'sensitivities.csv');
        const draw = () => charts.replaceChildren(makeScatter(x.get(), y.get()), makeHistogram(y.get(), result.summary?.statistics?.[y.get().name]), ...[sensitivities && makeTornado(sensitivities, y.get())].filter(Boolean));
        for (const one of [x, y]) one.select.addEventListener('change', draw);
        draw();
        parts.push(element('div', {class: 'tools'}, y.element, x.element), charts);
        if (result.study.left_out > 0)
            parts.push(element('p', {class: 'remark'}, `The charts show every ${result.study.every}th case; the tables count all.`));
    }
    return element('div', {}, ...parts, ...makeStudyTables(result));
}
