// SPDX-License-Identifier: BSD-3-Clause
// Tables: aligned numbers, units in the heads, a button for the rows that are not shown at first.
'use strict';

const kShownRows = 12;

function cell(value, digits) {
    if (typeof value === 'number' || value === null || value === undefined)
        return element('td', {class: 'number'}, formatNumber(value, digits));
    return element('td', {class: String(value).length > 40 ? 'wide' : null}, String(value));
}

/**
 * A table in a frame of its own that scrolls sideways where it is too wide. columns: {name, unit, isText}. rows: lists of
 * numbers, texts, nulls; the first of each is its head. shown: rows at first, the rest after a button.
 */
function makeTable({caption, columns, rows, shown = kShownRows, digits = 6}) {
    const head = element('tr');
    for (const {name, unit, isText} of columns) {
        const unitText = formatUnit(unit);
        head.append(element('th', {scope: 'col', class: isText ? null : 'number'}, name,
                            unitText ? element('span', {class: 'unit'}, ` [${unitText}]`) : null));
    }
    const body = element('tbody');
    const addRows = (from, to) => {
        for (const row of rows.slice(from, to)) {
            const first = typeof row[0] === 'number' ? formatNumber(row[0], digits) : row[0] ?? '–';
            body.append(element('tr', {}, element('th', {scope: 'row', class: columns[0].isText === false ? 'number' : null}, first),
                                ...row.slice(1).map(value => cell(value, digits))));
        }
    };
    const isCut = rows.length > shown + 3;
    addRows(0, isCut ? shown : rows.length);
    const frame = element('div', {class: 'frame', tabindex: '0', role: 'region', 'aria-label': caption},
                          element('table', {}, element('caption', {}, caption), element('thead', {}, head), body));
    if (!isCut) return frame;
    const more = button(`${shown} of ${rows.length} rows: show all`, () => {
        addRows(shown, rows.length);
        more.remove();
    }, {class: 'more'});
    return element('div', {}, frame, more);
}

/** A table of a results folder. One of few rows and many columns, as static.csv, is turned: a row per column. */
function makeFileTable(table, resultName) {
    const caption = resultName ? `${table.file} of ${resultName}` : table.file;
    const columns = table.columns.map(({name, unit}) => ({name, unit, isText: unit === ''}));
    let shown;
    if (columns.length > 12 && table.rows.length <= 6) {
        const heads = table.rows.map((row, i) => (columns[0].isText ? String(row[0]) : table.rows.length > 1 ? `row ${i + 1}` : 'value'));
        const from = columns[0].isText ? 1 : 0;
        const rows = [];
        for (let c = from; c < columns.length; ++c)
            if (table.rows.some(row => row[c] !== 0))
                rows.push([columns[c].name, formatUnit(columns[c].unit), ...table.rows.map(row => row[c])]);
        const zeros = columns.length - from - rows.length;
        shown = makeTable({caption, columns: [{name: 'channel', isText: true}, {name: 'unit', isText: true}, ...heads.map(name => ({name}))], rows, shown: 24});
        return element('div', {}, shown, zeros > 0 ? element('p', {class: 'remark'}, `${counted(zeros, 'channel is', 'channels are')} zero and not listed.`) : null);
    }
    shown = makeTable({caption, columns, rows: table.rows});
    return table.left_out > 0
        ? element('div', {}, shown, element('p', {class: 'remark'}, `${table.left_out} more rows are in ${table.file}.`))
        : shown;
}
