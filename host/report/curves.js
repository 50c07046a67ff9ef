// SPDX-License-Identifier: BSD-3-Clause
// Curves over time, frequency, speed or a parameter: one chart per unit, with common zoom and cursor, of any channels of
// several results.
'use strict';

const kUnitsFirst = ['N', 'm/s^2', 'm', 'N*m', 'Hz', 'm/s', 'rad', 'rad/s', 'Pa', 'J'];
const kMostAtFirst = 4;  // curves of a chart
const kXNames = {rpm: 'speed'};
const kChartHeight = 270;

/** Curves of one file, of all results that have it. sets: {set, result} with result the name of the results. */
class CurvePanel {
    constructor(sets, hasSeveralResults) {
        this.series = [];
        this.constants = [];
        this.x = {name: kXNames[sets[0].set.x] ?? sets[0].set.x, unit: sets[0].set.x_unit};
        this.hasSeveralResults = hasSeveralResults;
        this.span = Math.max(...sets.map(({set}) => set.span));
        for (const {set, result, index} of sets) this.take(set, hasSeveralResults ? result : '', index);
        this.hasPhases = this.series.some(one => one.phases);
        this.scale = 'linear';
        this.isPhaseShown = false;
        this.charts = [];
        this.chosen = new Set(this.chooseAtFirst());
        this.chartsBox = element('div', {class: 'charts'});
        this.element = element('div', {class: 'panel'}, element('div', {}, this.makeTools(), this.chartsBox, this.makeRemark()), this.makePicker());
        theme.watch(() => this.draw());
    }

    take(set, result, index) {
        if (set.rows === 0) return;
        const places = decodeDoubles(set.places);
        for (const curve of set.curves) {
            const name = [curve.name, set.label].filter(Boolean).join(', ');
            if ('constant' in curve) {
                this.constants.push({...curve, name, result});
                continue;
            }
            this.series.push({
                ...curve, name, result, index, places,
                label: result ? `${name} (${result})` : name,
                values: decodeFloats(curve.values),
                phases: curve.phases ? decodeFloats(curve.phases) : null,
                size: Math.max(Math.abs(curve.least ?? 0), Math.abs(curve.largest ?? 0)),
                range: (curve.largest ?? 0) - (curve.least ?? 0),
            });
        }
    }

    /** Channels by unit, first those that engineers look at first. */
    units() {
        const rank = unit => { const found = kUnitsFirst.indexOf(unit); return found < 0 ? kUnitsFirst.length : found; };
        return [...new Set(this.series.map(one => one.unit))].sort((a, b) => rank(a) - rank(b));
    }

    /** Names of the channels of a unit, those that move most first. */
    namesOf(unit) {
        const ranges = new Map();
        for (const one of this.series)
            if (one.unit === unit) ranges.set(one.name, Math.max(ranges.get(one.name) ?? 0, one.range));
        return [...ranges.keys()].sort((a, b) => ranges.get(b) - ranges.get(a));
    }

    chooseAtFirst() {
        const chosen = [];
        for (const unit of this.units().slice(0, this.x.name === 'time' ? 2 : 1)) {
            const names = this.namesOf(unit);
            const range = name => Math.max(...this.series.filter(one => one.name === name).map(one => one.range));
            const moving = names.filter(name => range(name) > 1e-6 * range(names[0]));
            const different = moving.filter((name, i) => !moving.slice(0, i).some(other => this.areEqual(name, other)));
            chosen.push(...different.slice(0, this.hasSeveralResults ? 1 : kMostAtFirst));
        }
        return chosen;
    }

    /** Whether two channels have the same curves, up to round-off, as those of symmetric bolts. */
    areEqual(name, other) {
        return this.series.filter(one => one.name === name).every(one => {
            const twin = this.series.find(two => two.name === other && two.index === one.index);
            return twin && twin.values.length === one.values.length && one.values.every((value, i) => Math.abs(value - twin.values[i]) <= 1e-6 * one.range);
        });
    }

    makeTools() {
        const tools = element('div', {class: 'tools'});
        const zoom = factor => () => this.zoom(factor);
        tools.append(button('Zoom in', zoom(0.5)), button('Zoom out', zoom(2)), button('Whole range', () => this.zoom(0)));
        if (this.hasPhases || this.x.name === 'frequency') {
            const choice = element('select', {onchange: () => { this.scale = choice.value; this.draw(); }});
            for (const [value, text] of [['linear', 'linear'], ['log', 'logarithmic'], ['dB', 'dB']])
                choice.append(element('option', {value}, text));
            tools.append(element('label', {}, 'Magnitude', choice));
            const onX = element('input', {type: 'checkbox', onchange: () => { this.isLogarithmicX = onX.checked; this.draw(); }});
            tools.append(element('label', {}, onX, `logarithmic ${this.x.name}`));
        }
        if (this.hasPhases) {
            const phase = element('input', {type: 'checkbox', onchange: () => { this.isPhaseShown = phase.checked; this.draw(); }});
            tools.append(element('label', {}, phase, 'phase'));
        }
        return tools;
    }

    makeRemark() {
        const help = 'Drag over a chart to zoom, double-click for the whole range. With the keyboard: arrows move the cursor, + and − zoom, Home shows the whole range.';
        const texts = [];
        if (this.span > 1)
            texts.push(`These are thinned curves: of every ${formatNumber(this.span, 3)} rows they show the least and the largest value. The tables have the values of all rows.`);
        if (this.constants.length > 0)
            texts.push(`${counted(this.constants.length, 'channel is', 'channels are')} constant and ${this.constants.length === 1 ? 'is' : 'are'} not drawn; ` +
                       'the table of extremes lists them.');
        return element('div', {}, element('p', {class: 'remark help'}, help), ...texts.map(text => element('p', {class: 'remark'}, text)));
    }

    makePicker() {
        const list = element('div', {class: 'list', tabindex: '0', role: 'group', 'aria-label': 'Channels to draw'});
        const rows = [];
        for (const unit of this.units()) {
            const head = element('p', {class: 'group'}, unit === '1' ? 'without unit' : formatUnit(unit));
            list.append(head);
            for (const name of this.namesOf(unit)) {
                const box = element('input', {type: 'checkbox', onchange: () => {
                    if (box.checked) this.chosen.add(name); else this.chosen.delete(name);
                    this.draw();
                }});
                box.checked = this.chosen.has(name);
                const row = element('label', {}, box, name);
                rows.push({name, row, head, box});
                list.append(row);
            }
        }
        const filter = element('input', {type: 'search', placeholder: 'Find, e.g. bolt force.z', 'aria-label': 'Find channels', oninput: () => {
            const words = filter.value.toLowerCase().split(/\s+/).filter(Boolean);
            const heads = new Set();
            for (const {name, row, head} of rows) {
                row.hidden = !words.every(word => name.toLowerCase().includes(word));
                row.style.display = row.hidden ? 'none' : '';
                if (!row.hidden) heads.add(head);
            }
            for (const {head} of rows) head.hidden = !heads.has(head);
        }});
        const none = button('Clear', () => { this.chosen.clear(); for (const {box} of rows) box.checked = false; this.draw(); });
        return element('fieldset', {class: 'picker'}, element('legend', {}, `Channels (${rows.length})`), filter, element('div', {class: 'tools'}, none), list);
    }

    /** Draws the chosen channels anew. The page must hold the element: charts are as wide as it. */
    draw() {
        for (const chart of this.charts) chart.destroy();
        this.charts = [];
        this.chartsBox.replaceChildren();
        const names = [...this.chosen];
        const chosen = this.series.filter(one => this.chosen.has(one.name)).sort((a, b) => names.indexOf(a.name) - names.indexOf(b.name));
        if (chosen.length === 0) this.chartsBox.append(element('p', {class: 'muted'}, this.series.length > 0 ? 'Choose channels to draw.' : 'There is nothing to draw: no rows, or constant channels only.'));
        const styleOf = one => {
            const colour = names.length === 1 ? one.index : names.indexOf(one.name);
            const round = Math.floor(colour / theme.colours.length);
            return {colour: theme.colours[colour % theme.colours.length], dash: kDashes[(one.index + round) % kDashes.length]};
        };
        const key = `panel ${Math.random()}`;
        for (const unit of this.units()) {
            const drawn = chosen.filter(one => one.unit === unit);
            if (drawn.length > 0) this.charts.push(new Chart(this, drawn, unit, styleOf, key, this.scale));
        }
        const vibrating = chosen.filter(one => one.phases);
        if (this.isPhaseShown && vibrating.length > 0)
            this.charts.push(new Chart(this, vibrating.map(one => ({...one, values: one.phases, isPhase: true})), 'deg', styleOf, key, 'linear'));
    }

    /** factor: of the width of the range; 0: the whole. */
    zoom(factor) {
        if (this.charts.length === 0) return;
        const {plot, whole} = this.charts[0];
        const {min, max} = plot.scales.x;
        const centre = plot.cursor.idx !== null && plot.cursor.left >= 0 ? plot.data[0][plot.cursor.idx] : (min + max) / 2;
        const left = factor === 0 ? whole[0] : Math.max(whole[0], centre - (centre - min) * factor);
        const right = factor === 0 ? whole[1] : Math.min(whole[1], centre + (max - centre) * factor);
        if (right > left) this.show(left, right);
    }

    show(min, max) {
        for (const {plot} of this.charts)
            if (plot.scales.x.min !== min || plot.scales.x.max !== max) plot.setScale('x', {min, max});
    }

    /** Moves the cursor of all charts by points that can be seen. */
    move(chart, points) {
        const {plot} = chart;
        const xs = plot.data[0];
        const {min, max} = plot.scales.x;
        let index = plot.cursor.left >= 0 && plot.cursor.idx !== null ? plot.cursor.idx + points : xs.findIndex(x => x >= min);
        index = Math.min(Math.max(index, 0), xs.length - 1);
        const x = Math.min(Math.max(xs[index], min), max);
        plot.setCursor({left: plot.valToPos(x, 'x'), top: plot.over.clientHeight / 2});
    }
}

/** One chart: series of one unit, its legend with the values at the cursor. */
class Chart {
    constructor(panel, series, unit, styleOf, syncKey, scale) {
        this.panel = panel;
        this.series = series;
        this.unit = scale === 'dB' ? `dB re 1 ${formatUnit(unit)}`.trim() : formatUnit(unit);
        const toScale = value => (Number.isNaN(value) || (scale !== 'linear' && !(value > 0)) ? null : scale === 'dB' ? 20 * Math.log10(value) : value);
        // What is drawn as it is needs no copy, which a million points would feel
        const isPlain = values => scale === 'linear' && values.every(value => !Number.isNaN(value));
        const tables = series.map(one => [one.places, isPlain(one.values) ? one.values : Array.from(one.values, toScale)]);
        const areEqual = tables.every(([xs]) => xs === tables[0][0] || (xs.length === tables[0][0].length && xs.every((x, i) => x === tables[0][0][i])));
        const data = areEqual ? [tables[0][0], ...tables.map(table => table[1])] : uPlot.join(tables);
        this.whole = [data[0][0], data[0][data[0].length - 1]];
        this.styles = series.map(styleOf);
        const box = element('div', {class: 'plot', tabindex: '0', role: 'group', 'aria-label': `Chart, ${this.title()}. Arrow keys move the cursor, plus and minus zoom.`});
        box.addEventListener('keydown', event => this.press(event));
        this.root = element('figure', {class: 'chart'}, element('figcaption', {class: 'chart-title'}, this.title()), box, this.makeLegend());
        panel.chartsBox.append(this.root);
        this.plot = new uPlot(this.options(box.clientWidth || 600, scale, syncKey, areEqual), data, box);
        this.plot.root.querySelector('canvas').setAttribute('role', 'img');
        this.plot.root.querySelector('canvas').setAttribute('aria-label', this.description());
        this.resize = new ResizeObserver(() => {
            if (box.clientWidth > 0 && box.clientWidth !== this.plot.width) this.plot.setSize({width: box.clientWidth, height: kChartHeight});
        });
        this.resize.observe(box);
    }

    title() {
        const what = this.series[0].isPhase ? 'Phase' : this.series.length === 1 ? this.series[0].label : counted(this.series.length, 'curve', 'curves');
        return `${what}${this.unit ? ` [${this.unit}]` : ''} over ${this.panel.x.name}`;
    }

    /** For those who do not see it; the legend has the same as a table. */
    description() {
        const x = this.panel.x;
        return `${this.title()}: ` + this.series.map(one => `${one.label} from ${withUnit(one.least, one.unit, 4)} at ${withUnit(one.least_at, x.unit, 4)} to ` +
                                                            `${withUnit(one.largest, one.unit, 4)} at ${withUnit(one.largest_at, x.unit, 4)}`).join('; ');
    }

    options(width, scale, syncKey, areEqual) {
        const axis = label => ({stroke: theme.text, grid: {stroke: theme.faint, width: 1}, ticks: {stroke: theme.faint, width: 1}, label, labelSize: 22,
                                font: '12px system-ui, sans-serif', labelFont: '12px system-ui, sans-serif', labelGap: 0});
        const texts = (_, values) => values.map(value => (value === null ? '' : formatNumber(value, 5)));
        const arePoints = this.series[0].places.length <= 40;
        return {
            width, height: kChartHeight, legend: {show: false}, padding: [8, 26, 0, 0],
            scales: {x: {time: false, distr: this.panel.isLogarithmicX && this.whole[0] > 0 ? 3 : 1}, y: {distr: scale === 'log' ? 3 : 1}},
            axes: [{...axis(`${this.panel.x.name}${formatUnit(this.panel.x.unit) ? ` [${formatUnit(this.panel.x.unit)}]` : ''}`), values: texts},
                   {...axis(this.unit || 'value'), size: 68, values: texts}],
            series: [{}, ...this.series.map((one, i) => ({label: one.label, stroke: this.styles[i].colour, dash: this.styles[i].dash, width: 1.6,
                                                           points: {show: arePoints, size: 6}, spanGaps: !areEqual}))],
            cursor: {sync: {key: syncKey, setSeries: false}, drag: {x: true, y: false}, points: {size: 7}},
            hooks: {
                setCursor: [plot => this.readCursor(plot)],
                setScale: [(plot, key) => { if (key === 'x' && this.plot) this.panel.show(plot.scales.x.min, plot.scales.x.max); }],
            },
        };
    }

    makeLegend() {
        const x = this.panel.x;
        this.valueCells = [];
        const unit = text => element('span', {class: 'unit'}, text ? ` [${text}]` : '');
        this.cursorHead = element('th', {scope: 'col', class: 'number'}, 'at cursor');
        const head = element('tr', {}, element('th', {scope: 'col'}, 'curve', unit(this.unit)), this.cursorHead);
        if (!this.series[0].isPhase)
            for (const [name, text] of [['least', ''], ['at', formatUnit(x.unit)], ['largest', ''], ['at', formatUnit(x.unit)]])
                head.append(element('th', {scope: 'col', class: 'number'}, name, unit(text)));
        const body = element('tbody');
        this.series.forEach((one, i) => {
            const value = element('td', {class: 'number'}, '–');
            this.valueCells.push(value);
            const row = element('tr', {}, element('th', {scope: 'row'}, this.makeSwatch(i), one.label), value);
            if (!one.isPhase)
                for (const number of [one.least, one.least_at, one.largest, one.largest_at]) row.append(element('td', {class: 'number'}, formatNumber(number)));
            body.append(row);
        });
        return element('div', {class: 'frame legend', tabindex: '0', role: 'region', 'aria-label': `Values, ${this.title()}`},
                       element('table', {}, element('thead', {}, head), body));
    }

    makeSwatch(i) {
        const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
        svg.setAttribute('class', 'swatch');
        svg.setAttribute('viewBox', '0 0 30 10');
        svg.setAttribute('aria-hidden', 'true');
        const line = document.createElementNS('http://www.w3.org/2000/svg', 'line');
        for (const [name, value] of Object.entries({x1: 0, x2: 30, y1: 5, y2: 5, stroke: this.styles[i].colour, 'stroke-width': 3, 'stroke-dasharray': this.styles[i].dash.join(' ')}))
            line.setAttribute(name, value);
        svg.append(line);
        return svg;
    }

    readCursor(plot) {
        const {idx, left} = plot.cursor;
        const isOn = idx !== null && idx !== undefined && left >= 0;
        this.cursorHead.textContent = isOn ? `at ${withUnit(plot.data[0][idx], this.panel.x.unit)}` : 'at cursor';
        this.valueCells.forEach((cellOfValue, i) => { cellOfValue.textContent = isOn ? formatNumber(plot.data[i + 1][idx]) : '–'; });
    }

    press(event) {
        const step = event.shiftKey ? 10 : 1;
        const actions = {
            ArrowRight: () => this.panel.move(this, step), ArrowLeft: () => this.panel.move(this, -step),
            '+': () => this.panel.zoom(0.5), '=': () => this.panel.zoom(0.5), '-': () => this.panel.zoom(2),
            Home: () => this.panel.zoom(0), Escape: () => this.panel.zoom(0),
        };
        if (!actions[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
        event.preventDefault();
        actions[event.key]();
    }

    destroy() {
        this.resize.disconnect();
        this.plot.destroy();
    }
}
