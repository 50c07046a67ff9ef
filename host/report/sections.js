// SPDX-License-Identifier: BSD-3-Clause
// What the page says in words and tables, by the kind of results.
'use strict';

const kKinds = {run: 'Run', modes: 'Natural frequencies', static: 'Equilibrium', frf: 'Frequency response', response: 'Steady vibration', spectrum: 'Spectrum of a run', sweep: 'Sweep', study: 'Study',
                identify: 'Parameters from measurements', diagnose: 'Diagnosis', sensitivity: 'Sensitivities', optimise: 'Optimum'};

/** Status in words, and how good it is. Modes have none: they are there or the command has failed. */
function statusOf(result) {
    const status = result.summary?.status ?? (result.kind === 'modes' ? 'completed' : null);
    if (result.kind === 'sweep' && !result.summary) {
        const table = listOf(result.tables).find(one => one.file === 'sweep.csv');
        const column = table ? table.columns.findIndex(one => one.name === 'status') : -1;
        const all = table ? table.rows.length + table.left_out : 0;
        const failed = column < 0 ? 0 : table.rows.filter(row => row[column] !== 'completed').length;
        return failed > 0 ? {text: `${failed} of ${counted(all, 'case', 'cases')} not completed`, level: 'bad'}
                          : {text: counted(all, 'case', 'cases'), level: 'good'};
    }
    if (result.kind === 'study') {
        const s = result.summary ?? {};
        const rest = [[s.failed, 'failed'], [s.missing, 'not run'], [s.with_warnings, 'with warnings']].filter(([number]) => number > 0).map(([number, text]) => `, ${number} ${text}`);
        return {text: `${s.completed} of ${counted(s.cases, 'case', 'cases')} completed${rest.join('')}`, level: s.failed > 0 || s.missing > 0 ? 'bad' : s.with_warnings > 0 ? 'warn' : 'good'};
    }
    if (isVerdict(result)) return verdictStatus(result);
    if (!status) return {text: 'Status unknown', level: 'bad'};
    const reason = result.summary?.reason ? `: ${result.summary.reason}` : '';
    if (status !== 'completed') return {text: `${String(status).replaceAll('_', ' ')}${reason}`, level: 'bad'};
    const warnings = listOf(result.summary?.warnings).length;
    return warnings > 0 ? {text: `Completed, ${counted(warnings, 'warning or note', 'warnings or notes')}`, level: 'warn'} : {text: 'Completed, no warnings', level: 'good'};
}

/** The figures by which an engineer judges the results, shortest first. */
function factsOf(result) {
    const s = result.summary ?? {};
    const facts = [];
    if (result.kind === 'run') {
        const simulation = result.model?.simulation;
        if (s.steps) facts.push(`${s.steps} steps${s.tolerance ? ' in all runs' : ''}`);
        if (simulation?.duration) facts.push(`${formatNumber(simulation.duration)} s`);
        if (s.fastest_vibration?.omega_h > 0)
            facts.push(`fastest vibration ${formatNumber(s.fastest_vibration.frequency_hz, 4)} Hz, ${formatNumber(2 * Math.PI / s.fastest_vibration.omega_h, 3)} steps per period`);
        if (typeof s.tolerance?.relative_error === 'number')
            facts.push(`error of the time steps at most ${share(s.tolerance.relative_error)} of the largest value of its kind (asked for ${share(s.tolerance.tolerance)})`);
        const energy = s.energy;
        if (energy?.residual && energy?.work) facts.push(`energy residual ${formatNumber(energy.residual.peak, 2)} J of ${formatNumber(energy.work.peak, 3)} J work`);
    } else if (result.kind === 'modes') {
        facts.push(counted(listOf(s.frequencies_hz).length, 'mode', 'modes'));
        if (s.beams) facts.push(`beams ${s.beams}`);
    } else if (result.kind === 'static') {
        if (typeof s.largest_unbalanced_force_n === 'number')
            facts.push(`forces balance to ${formatNumber(s.largest_unbalanced_force_n, 2)} N; the largest is ${formatNumber(s.largest_force_n, 4)} N`);
        if (typeof s.loads_at_s === 'number') facts.push(`loads at t = ${formatNumber(s.loads_at_s)} s`);
    } else if (result.kind === 'spectrum') {
        if (s.resolution_hz) facts.push(`resolution ${formatNumber(s.resolution_hz, 4)} Hz, ${s.taper} window, ${counted(s.segments, 'segment', 'segments')}`);
    } else if (s.rows) {
        facts.push(`${s.rows} frequencies`);
    }
    return facts;
}

function makeHead(data, results) {
    const head = [element('h1', {}, data.title)];
    for (const result of results) {
        const status = statusOf(result);
        head.push(element('p', {class: 'verdict'}, results.length > 1 ? element('strong', {}, result.name) : null,
                          element('span', {}, kKinds[result.kind] ?? result.kind),
                          element('span', {class: `status ${status.level}`}, status.text),
                          element('span', {class: 'muted'}, factsOf(result).join(' · '))));
    }
    for (const result of results) {
        const warnings = listOf(result.summary?.warnings);
        const of = results.length > 1 ? ` of ${result.name}` : '';
        if (warnings.length > 0)
            head.push(element('div', {class: 'notice', role: 'note'}, element('strong', {}, `Warnings and notes${of}`),
                              element('ul', {}, ...warnings.map(one => element('li', {}, String(one.text ?? one), ' ', element('code', {}, String(one.code ?? '')))))));
        const notes = listOf(result.notes);
        if (notes.length > 0)
            head.push(element('div', {class: 'notice', role: 'note'}, element('strong', {}, `About this report${of}`),
                              element('ul', {}, ...notes.map(note => element('li', {}, note)))));
    }
    return head;
}

/** Least, largest and last value of every channel of the histories, with times. Constant ones are below. */
function makeExtremes(result) {
    const set = listOf(result.curve_sets).find(one => one.file === 'history.csv');
    if (!set) return null;
    const rank = unit => { const found = kUnitsFirst.indexOf(unit); return found < 0 ? kUnitsFirst.length : found; };
    const size = one => Math.max(Math.abs(one.least), Math.abs(one.largest));
    const moving = set.curves.filter(one => !('constant' in one)).sort((a, b) => rank(a.unit) - rank(b.unit) || size(b) - size(a));
    const constant = set.curves.filter(one => 'constant' in one);
    const columns = [{name: 'channel', isText: true}, {name: 'unit', isText: true}, {name: 'least'}, {name: 'at', unit: 's'}, {name: 'largest'}, {name: 'at', unit: 's'}, {name: 'last'}];
    const rows = moving.map(one => [one.name, formatUnit(one.unit), one.least, one.least_at, one.largest, one.largest_at, one.last]);
    const parts = [makeTable({caption: `Over the ${set.rows} recorded rows, ${result.name}`, columns, rows})];
    if (constant.length > 0)
        parts.push(element('details', {}, element('summary', {}, `${counted(constant.length, 'channel is', 'channels are')} constant`),
                           makeTable({caption: `Constant channels, ${result.name}`, columns: [{name: 'channel', isText: true}, {name: 'unit', isText: true}, {name: 'value'}],
                                      rows: constant.map(one => [one.name, formatUnit(one.unit), one.constant]), shown: 30})));
    return element('div', {}, ...parts);
}

function largestShares(shares, most = 4) {
    const sorted = entriesOf(shares).filter(([, value]) => value >= 0.005).sort((a, b) => b[1] - a[1]);
    const rest = sorted.length - most;
    return sorted.slice(0, most).map(([name, value]) => `${name} ${share(value, 2)}`).join(', ') + (rest > 0 ? ` and ${rest} more` : '');
}

function makeModes(result) {
    const modes = listOf(result.summary?.modes);
    const columns = [{name: 'mode', isText: false}, {name: 'frequency', unit: 'Hz'}, {name: 'multiplicity'}, {name: 'modal mass', unit: 'kg'}, {name: 'kinetic energy', isText: true}, {name: 'strain energy', isText: true}];
    const rows = modes.map((mode, i) => [i + 1, mode.frequency_hz, mode.multiplicity, mode.modal_mass, mode.kind || largestShares(mode.kinetic_energy) || '–', largestShares(mode.strain_energy) || '–']);
    const parts = [makeTable({caption: `Natural frequencies, ${result.name}`, columns, rows, shown: 20})];
    const totals = entriesOf(result.summary?.effective_mass_totals);
    if (totals.length > 0)
        parts.push(element('p', {class: 'remark'}, `Effective mass of these modes: ${totals.map(([direction, value]) => `${direction} ${share(value, 4)}`).join(', ')}. ` +
                                                    'Shares below 0.5 % are left out here; energies.csv has all.'));
    return element('div', {}, ...parts);
}

function makeProvenance(result) {
    const s = result.summary ?? {};
    const list = element('dl');
    const add = (name, value, isCode) => { if (value) list.append(element('dt', {}, name), element('dd', {}, isCode ? element('code', {}, String(value)) : String(value))); };
    add('Results', result.path, true);
    add('Command', s.command_line, true);
    add('Written', result.written);
    add('Program', [s.versions?.dttmm ?? s.inputs?.version, s.versions?.ode ? `ODE ${s.versions.ode}` : ''].filter(Boolean).join(', '));
    add('Plugins', entriesOf(s.versions?.plugins).map(([name, version]) => `${name}: ${version}`).join('; '));
    add('Build', s.inputs?.build, true);
    add('Options', entriesOf(s.inputs?.options).map(([name, value]) => `${name} ${value}`).join(', '), true);
    add('History', s.history, true);
    add('Computing time', typeof s.wall_time === 'number' ? `${formatNumber(s.wall_time, 3)} s` : '');
    const parts = [list];
    const parameters = entriesOf(result.model?.parameters);
    if (parameters.length > 0)
        parts.push(makeTable({caption: `Parameters of ${result.name}, in SI units`, columns: [{name: 'parameter', isText: true}, {name: 'value'}], rows: parameters}));
    if (result.model_text)
        parts.push(element('details', {}, element('summary', {}, 'Model file'), element('pre', {tabindex: '0', role: 'region', 'aria-label': `Model file of ${result.name}`}, result.model_text)));
    return element('div', {}, ...parts);
}
