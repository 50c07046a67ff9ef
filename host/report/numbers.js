// SPDX-License-Identifier: BSD-3-Clause
// Numbers and texts: decoding, formatting, small elements of the page. Texts of results are data: they only ever become
// text nodes and attributes, never HTML.
'use strict';

function decodeBytes(text) {
    if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text).buffer;
    const raw = atob(text);
    const bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; ++i) bytes[i] = raw.charCodeAt(i);
    return bytes.buffer;
}

/** Numbers of four bytes, as base64_of_floats() writes them. */
const decodeFloats = text => new Float32Array(decodeBytes(text));
/** Numbers of eight bytes, as base64_of_doubles() writes them. */
const decodeDoubles = text => new Float64Array(decodeBytes(text));

/** A number to read: so many significant digits, a dash where there is none. */
function formatNumber(value, digits = 6) {
    if (typeof value !== 'number' || !Number.isFinite(value)) return '–';
    if (value === 0) return '0';
    const size = Math.abs(value);
    const text = size >= 1e-3 && size < 1e7 ? String(Number(value.toPrecision(digits)))
                                            : value.toExponential(digits - 1).replace(/\.?0+e/, 'e').replace('e+', 'e');
    return text.replace('-', '−').replace('e-', 'e−');
}

/** "m/s^2" as m/s²; a pure number has no unit. */
function formatUnit(unit) {
    if (!unit || unit === '1') return '';
    return unit.replaceAll('^2', '²').replaceAll('^3', '³').replaceAll('*', '·');
}

const withUnit = (value, unit, digits) => `${formatNumber(value, digits)} ${formatUnit(unit)}`.trim();
const counted = (count, one, many) => `${count} ${count === 1 ? one : many}`;
const share = (value, digits = 3) => `${formatNumber(100 * value, digits)} %`;

/** An element with attributes and children; texts become text nodes. */
function element(tag, attributes = {}, ...children) {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
        if (value === false || value === undefined || value === null) continue;
        if (name.startsWith('on')) made.addEventListener(name.slice(2), value);
        else made.setAttribute(name, value === true ? '' : value);
    }
    made.append(...children.filter(child => child !== null && child !== undefined));
    return made;
}

const button = (text, press, attributes = {}) => element('button', {type: 'button', onclick: press, ...attributes}, text);

/** Members of what may be no object: a damaged summary has anything anywhere. */
const entriesOf = thing => (thing && typeof thing === 'object' ? Object.entries(thing) : []);
const listOf = thing => (Array.isArray(thing) ? thing : []);

/** Colours that people of every colour vision tell apart (Okabe and Ito), darker or lighter for the background. */
const kLightColours = ['#0072b2', '#c04e00', '#00795a', '#a3477b', '#8a6a00', '#2a8fc9', '#5b5b5b'];
const kDarkColours = ['#62b5f0', '#f0a030', '#37cfa5', '#e9a0cc', '#efe25a', '#ff8a5c', '#d0d0d0'];
const kDashes = [[], [9, 4], [2, 4], [12, 4, 2, 4], [5, 3], [16, 5]];

/** Light or dark; a printed page is light. Calls back at every change. */
const theme = {
    query: window.matchMedia('(prefers-color-scheme: dark)'),
    isPrinting: false,
    listeners: [],
    get isDark() { return this.query.matches && !this.isPrinting; },
    get colours() { return this.isDark ? kDarkColours : kLightColours; },
    get text() { return this.isDark ? '#e4e4e0' : '#1d1f21'; },
    get faint() { return this.isDark ? '#3a3d40' : '#e2e2de'; },
    get ground() { return this.isDark ? '#17191b' : '#ffffff'; },
    watch(listener) { this.listeners.push(listener); },
    tell() { for (const listener of this.listeners) listener(); },
};
theme.query.addEventListener('change', () => theme.tell());
for (const [event, isPrinting] of [['beforeprint', true], ['afterprint', false]])
    window.addEventListener(event, () => { theme.isPrinting = isPrinting; if (theme.query.matches) theme.tell(); });
