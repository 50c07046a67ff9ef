// SPDX-License-Identifier: BSD-3-Clause
// Puts the page together from the data that stand in it.
'use strict';

(() => {
    const kCurveTitles = {'history.csv': 'Curves over time', 'response.csv': 'Steady vibration', 'frf.csv': 'Frequency response', 'psd.csv': 'Power spectral densities',
                          'spectrum.csv': 'Spectrum', 'determinant.csv': 'Determinant', 'orders.csv': 'Orders'};
    const data = JSON.parse(document.getElementById('data').textContent);
    const main = document.getElementById('main');
    const contents = element('ul');
    let startMachine = () => {};  // once the rest is drawn: a graphics driver takes its time

    /** Results are known by the last part of their path, or by all of it where that is not enough. */
    function nameResults(results) {
        const last = path => path.replace(/\/+$/, '').split('/').pop() || path;
        const names = results.map(result => last(result.path));
        results.forEach((result, i) => { result.name = names.filter(name => name === names[i]).length > 1 ? result.path : names[i]; });
    }

    /** A part of the page that cannot be made says so and leaves the others. */
    function attempt(section, make) {
        try {
            const made = make(section);
            if (made) section.append(made);
        } catch (fault) {
            console.error(fault);
            section.append(element('p', {class: 'notice bad'}, `This part cannot be shown: ${fault.message}`));
        }
    }

    function addSection(title, id, make) {
        const section = element('section', {id, 'aria-labelledby': `${id}-title`}, element('h2', {id: `${id}-title`}, title));
        main.append(section);
        attempt(section, make);
        contents.append(element('li', {}, element('a', {href: `#${id}`}, title)));
    }

    const results = data.results;
    nameResults(results);
    const several = results.length > 1;
    const all = make => element('div', {}, ...results.map(make).filter(Boolean));

    document.getElementById('head').append(...makeHead(data, results));
    if (results.some(result => result.kind === 'modes')) addSection('Modes', 'modes', () => all(result => result.kind === 'modes' && makeModes(result)));
    if (results.some(result => result.kind === 'study')) addSection('Study', 'study', () => all(result => result.kind === 'study' && makeStudy(result)));
    if (results.some(isVerdict)) addSection('Verdict', 'verdict', () => all(result => isVerdict(result) && makeVerdict(result)));
    if (data.has_machine) addSection('Machine', 'machine', section => { startMachine = () => requestAnimationFrame(() => setTimeout(() => attempt(section, () => addMachine(section, results)))); });

    const files = [...new Set(results.flatMap(result => listOf(result.curve_sets).map(set => set.file)))];
    for (const file of files) {
        const sets = results.flatMap((result, index) => listOf(result.curve_sets).filter(set => set.file === file).map(set => ({set, result: result.name, index})));
        const fit = file.match(/^(histories|responses)-\d+\.csv$/);
        addSection(kCurveTitles[file] ?? (fit ? `Measured and predicted ${fit[1]}` : `Sweep over ${sets[0].set.x}`), `curves-${file.replace('.', '-')}`, section => {
            const panel = section.panel = new CurvePanel(sets, several);
            section.append(panel.element);
            panel.draw();
            const swept = file === 'sweep.csv' ? results.filter(result => result.has_cases) : [];
            for (const {path} of swept) section.append(element('p', {class: 'remark'}, `Every case has results of its own: dttmm report ${path}/case-*`));
        });
    }
    if (results.some(result => listOf(result.curve_sets).some(set => set.file === 'history.csv')))
        addSection('Extremes', 'extremes', () => all(makeExtremes));
    const hasTables = result => result.kind !== 'study' && listOf(result.tables).length > 0;
    if (results.some(hasTables))
        addSection('Tables', 'tables', () => all(result => hasTables(result) && element('div', {}, ...listOf(result.tables).map(table => makeFileTable(table, several ? result.name : '')))));
    addSection('Model and origin', 'origin', () => all(result => element('div', {}, several ? element('h3', {}, result.name) : null, makeProvenance(result))));

    document.getElementById('contents').append(contents);
    document.getElementById('maker').textContent = `Made by ${data.program}: ${data.command_line}`;
    document.documentElement.dataset.ready = 'yes';
    startMachine();
})();
