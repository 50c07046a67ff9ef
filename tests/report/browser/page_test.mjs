// SPDX-License-Identifier: BSD-3-Clause
// Reports of real results in Chromium: under their strict policy, with the numbers of the files, by keyboard, in both
// schemes, on a phone. Oracle of every number: the CSV file beside the report, read here.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {cpSync, mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {chromium} from 'playwright-core';

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const folder = mkdtempSync(join(tmpdir(), 'dttmm-report-'));
const examples = process.env.EXAMPLES;
const dttmm = (...words) => execFileSync(process.env.DTTMM, words, {cwd: folder, encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe']});
let browser;

const kHostile = '</script><script>window.harmed = 1</script><img src=x onerror="window.harmed = 1">';

before(async () => {
    dttmm('run', join(examples, 'four_bolt_plate'), '-o', 'plate', '--duration', '0.2 s', '--set', 'k1=400 N/mm');
    dttmm('run', join(examples, 'four_bolt_plate'), '-o', 'other', '--duration', '0.2 s');
    dttmm('modes', join(examples, 'hydroplane'), '-o', 'modes');
    dttmm('response', join(examples, 'engine_on_inclined_mounts'), '-o', 'response', '--rpm', '800..6000', '--out', 'mount*.force');
    dttmm('static', join(examples, 'loaded_girder'), '-o', 'static', '--at', '2 s');
    dttmm('run', join(examples, 'pendulum_on_bolts'), '-o', 'pendulum', '--duration', '2 s');
    dttmm('run', join(examples, 'four_bolt_plate'), '-o', 'sweep', '--duration', '0.1 s', '--sweep', 'k1=300 N/mm..500 N/mm:3');
    const study = (...words) => dttmm('study', join(examples, 'four_bolt_plate'), '--vary', 'k, k1 ~ uniform(300 N/mm, 600 N/mm)', '--duration', '0.05 s', '-q', ...words);
    study('-o', 'single', '--design', 'one-at-a-time', '--figures', 'bolt[12].force.z:peak');
    const loose = join(examples, 'loose_bolt');
    dttmm('identify', loose, '--free', 'k1,k2,c', '--starts', '1', '-o', 'identify');
    dttmm('identify', join(loose, 'frame.toml'), '--free', 'k1..k4', '-o', 'frame');
    dttmm('diagnose', loose, '--suspects', 'bolt*', '--free', 'c', '--step', '0.5 ms', '-o', 'diagnose');
    dttmm('sensitivity', join(examples, 'scattered_bolts'), '--of', 'mode*.frequency', '--by', 'k1..k4', '-o', 'sensitivity');
    dttmm('optimise', join(examples, 'scattered_bolts'), '--goal', 'mode1.frequency = 80 Hz', '--by', 'k1..k4 in 0.5..2', '--starts', '2', '-o', 'optimise');
    study('-o', 'indices', '--design', 'sobol-indices', '--cases', '64', '--figures', 'bolt[12].force.z:peak');
    const model = readFileSync(join(examples, 'four_bolt_plate', 'model.toml'), 'utf8').replace(/^title\s*=.*$/m, `title = '''${kHostile}'''`);
    writeFileSync(join(folder, 'hostile.toml'), model);
    dttmm('run', 'hostile.toml', '-o', 'hostile', '--duration', '0.05 s');
    writeFileSync(join(folder, 'beam.toml'), `format = "dttmm/1"
[simulation]
duration = "20 ms"
step = "0.5 ms"
gravity = [0, -3, -9]
[nodes]
left = { position = [0.1, 0.2, 0.3], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
right = { position = [0.7, 0.5, 0.9], fixed = ["x", "y", "z"] }
[[element]]
name = "arm"
type = "beam"
from = "left"
to = "right"
segments = 20
section = { tube = ["12 mm", "8 mm"] }
material = { E = "70 GPa", poisson = 0.33, density = 2700 }
`);
    dttmm('run', 'beam.toml', '-o', 'beam', '--for-report');
    dttmm('run', 'beam.toml', '-o', 'straight');
    browser = await chromium.launch({executablePath: process.env.CHROMIUM, args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader']});
});

after(async () => {
    await browser?.close();
    rmSync(folder, {recursive: true, force: true});
});

/** Columns of a CSV file by name: numbers, its two heading lines left out. */
function columnsOf(file) {
    const [names, , ...rows] = readFileSync(join(folder, file), 'utf8').trim().split('\n').map(line => line.split(','));
    return Object.fromEntries(names.map((name, c) => [name, rows.map(row => Number(row[c]))]));
}

/** Opens a report of results; says what the browser complained of and asked for. */
async function open(results, {colorScheme = 'light', width = 1200, reducedMotion = 'reduce', words = []} = {}) {
    const file = join(folder, `${results.join('-')}.html`);
    dttmm('report', ...results, '-o', file, ...words);
    const context = await browser.newContext({viewport: {width, height: 900}, colorScheme, reducedMotion});
    const page = await context.newPage();
    const complaints = [], requests = [];
    page.on('console', message => { if (message.type() === 'error') complaints.push(message.text()); });
    page.on('pageerror', fault => complaints.push(fault.message));
    page.on('request', request => requests.push(request.url()));
    await page.goto(`file://${file}`);
    await page.waitForFunction(() => document.documentElement.dataset.ready === 'yes');
    if (await page.locator('#machine').count()) await page.waitForFunction(() => document.getElementById('machine').view || document.querySelector('#machine .notice'));
    return {page, complaints, requests, close: () => context.close()};
}

const parse = text => Number(text.replace('−', '-').replace('−', '-'));
const near = (found, wanted, digits = 6) => assert.ok(Math.abs(found - wanted) <= 0.6 * 10 ** (1 - digits) * Math.abs(wanted) + 1e-300, `${found} is not ${wanted}`);

/** A row of numbers of a table by its head. */
const rowOf = (page, table, head) => page.locator(`${table} tr`, {has: page.locator('th[scope="row"]', {hasText: new RegExp(`^${head.replaceAll('.', '\\.')}$`)})}).first().locator('td').allTextContents();

/** What stands in the picture of the machine: a mark of all pixels, and how many colours there are. */
const picture = page => page.evaluate(() => {
    const {view} = document.getElementById('machine');
    view.render(performance.now());
    const copy = document.createElement('canvas');
    [copy.width, copy.height] = [view.canvas.width, view.canvas.height];
    const drawing = copy.getContext('2d');
    drawing.drawImage(view.canvas, 0, 0);
    const pixels = new Uint32Array(drawing.getImageData(0, 0, copy.width, copy.height).data.buffer);
    let mark = 0;
    for (const pixel of pixels) mark = (Math.imul(mark, 31) + pixel) | 0;
    return {mark, colours: new Set(pixels).size};
});

test('every kind of results opens without a complaint, by one request, under the policy', async () => {
    for (const results of [['plate'], ['modes'], ['response'], ['static'], ['sweep'], ['single'], ['indices'], ['identify'], ['frame'], ['diagnose'], ['sensitivity'], ['optimise'], ['plate', 'other']]) {
        const {page, complaints, requests, close} = await open(results);
        assert.deepEqual(complaints, [], results.join());
        assert.equal(requests.length, 1, requests.join());
        const policy = await page.locator('meta[http-equiv="Content-Security-Policy"]').getAttribute('content');
        assert.match(policy, /^default-src 'none';/);
        assert.doesNotMatch(policy, /unsafe/);
        const ran = await page.evaluate(() => {
            const script = document.createElement('script');
            script.textContent = 'window.strange = 1';
            document.head.append(script);
            return window.strange ?? 0;
        });
        assert.equal(ran, 0, 'a strange script must not run');
        await close();
    }
});

test('a text of a model is a text', async () => {
    const {page, complaints, close} = await open(['hostile']);
    assert.equal(await page.locator('h1').textContent(), kHostile);
    assert.equal(await page.title(), kHostile);
    assert.equal(await page.evaluate(() => window.harmed ?? 0), 0);
    assert.deepEqual(complaints, []);
    await close();
});

test('a damaged model costs its picture only, and the page says so', async () => {
    cpSync(join(folder, 'plate'), join(folder, 'damaged'), {recursive: true});
    const summary = JSON.parse(readFileSync(join(folder, 'damaged/summary.json'), 'utf8'));
    summary.model.bodies.plate.position = ['a', {}, null];
    summary.warnings = {code: [3]};
    summary.energy = 'none';
    writeFileSync(join(folder, 'damaged/summary.json'), JSON.stringify(summary));
    const {page, close} = await open(['damaged']);
    assert.match(await page.locator('#machine .notice').textContent(), /cannot be shown: the model in summary.json has places that are no numbers/);
    assert.ok(await page.locator('#curves-history-csv canvas').count() > 0);
    assert.ok(await page.locator('#extremes tbody tr').count() > 5);
    await close();
});

test('cursor and table of extremes show the numbers of history.csv', async () => {
    const {page, close} = await open(['plate']);
    const history = columnsOf('plate/history.csv');
    const chart = page.locator('#curves-history-csv .chart').first();
    const heads = await chart.locator('tbody th').allTextContents();
    assert.ok(heads.includes('bolt1.force.z') || heads.includes('bolt2.force.z'), heads.join());
    await chart.locator('.plot').focus();
    for (let i = 0; i < 18; ++i) await page.keyboard.press('ArrowRight');
    const row = 17;  // the first press puts the cursor on row 0
    near(parse((await chart.locator('thead th').nth(1).textContent()).match(/at (\S+) s/)[1]), history.time[row]);
    for (const name of heads) {
        const values = history[name];
        const [atCursor, least, leastAt, largest, largestAt] = (await rowOf(page, '#curves-history-csv .chart', name)).map(parse);
        near(atCursor, values[row]);
        near(least, Math.min(...values));
        near(leastAt, history.time[values.indexOf(Math.min(...values))]);
        near(largest, Math.max(...values));
        near(largestAt, history.time[values.indexOf(Math.max(...values))]);
        const [, fromTable, , toTable, , last] = await rowOf(page, '#extremes', name);
        near(parse(fromTable), least);
        near(parse(toTable), largest);
        near(parse(last), values.at(-1));
    }
    await close();
});

test('the drawn points are those of history.csv, of all results', async () => {
    const {page, close} = await open(['plate', 'other']);
    const drawn = await page.evaluate(() => document.querySelector('#curves-history-csv').panel.series.filter(one => one.name === 'bolt1.force.z')
        .map(one => ({result: one.result, values: [...one.values], places: [...one.places]})));
    assert.deepEqual(drawn.map(one => one.result), ['plate', 'other']);
    for (const {result, values, places} of drawn) {
        const history = columnsOf(`${result}/history.csv`);
        assert.deepEqual(places, history.time);
        assert.deepEqual(values, history['bolt1.force.z'].map(Math.fround));
    }
    await close();
});

test('more rows than points are drawn by least and largest value, and the page says so', async () => {
    dttmm('run', join(examples, 'four_bolt_plate'), '-o', 'long', '--step', '0.04 ms', '--duration', '0.4 s', '--output-step', '0.04 ms');
    const {page, close} = await open(['long'], {words: ['--points', '1000', '--channels', 'bolt1.force.z,plate.position']});
    const force = columnsOf('long/history.csv')['bolt1.force.z'];
    assert.equal(force.length, 10001);
    const values = await page.evaluate(() => [...document.querySelector('#curves-history-csv').panel.series.find(one => one.name === 'bolt1.force.z').values]);
    assert.equal(values.length, 1000);
    assert.equal(Math.max(...values), Math.fround(Math.max(...force)));
    assert.equal(Math.min(...values), Math.fround(Math.min(...force)));
    for (let s = 0; s < 500; ++s) {
        const span = force.slice(Math.floor(s * 10001 / 500), Math.floor((s + 1) * 10001 / 500)).map(Math.fround);
        assert.equal(Math.max(values[2 * s], values[2 * s + 1]), Math.max(...span), `span ${s}`);
    }
    assert.match(await page.locator('#curves-history-csv').textContent(), /of every 20 rows they show the least and the largest value/);
    await close();
});

test('magnitude and phase of a response are those of its real and imaginary part', async () => {
    const {page, close} = await open(['response']);
    const rows = columnsOf('response/response.csv');
    const wanted = rows.rpm.map((rpm, i) => ({rpm, order: rows.order[i], re: rows['mount1.force.z.re'][i], im: rows['mount1.force.z.im'][i]}))
        .filter(one => one.order === 2).sort((a, b) => a.rpm - b.rpm);
    const found = await page.evaluate(() => {
        const one = document.querySelector('#curves-response-csv').panel.series.find(two => two.name === 'mount1.force.z, order 2');
        return {places: [...one.places], values: [...one.values], phases: [...one.phases]};
    });
    assert.deepEqual(found.places, wanted.map(one => one.rpm));
    wanted.forEach(({re, im}, i) => {
        near(found.values[i], Math.hypot(re, im));
        assert.ok(Math.abs(found.phases[i] - Math.atan2(im, re) * 180 / Math.PI) < 1e-4);
    });
    await close();
});

// Oracle: sensitivities.csv: of a figure the change from the least to the largest of every parameter, the widest on top.
test('what each parameter does is drawn as sensitivities.csv has it, the strongest on top', async () => {
    const {page, close} = await open(['single']);
    const rows = readFileSync(join(folder, 'single/sensitivities.csv'), 'utf8').trim().split('\n').slice(2).map(line => line.split(','));
    for (const figure of ['bolt1.force.z.peak', 'bolt2.force.z.peak']) {
        await page.locator('.tools label', {hasText: 'figure'}).locator('select').selectOption(figure);
        const own = rows.filter(row => row[0] === figure);
        const spans = [...new Set(own.map(row => row[2]))].map(name => {
            const changes = [0, ...own.filter(row => row[2] === name).map(row => Number(row[4]))];
            return {name, span: Math.max(...changes) - Math.min(...changes)};
        }).sort((a, b) => b.span - a.span);
        const chart = page.locator('figure', {hasText: 'What each parameter does to'});
        const widths = await chart.locator('rect.bar').evaluateAll(bars => bars.map(bar => Number(bar.getAttribute('width'))));
        assert.equal(widths.length, 2);
        near(widths[1] / widths[0], spans[1].span / spans[0].span, 4);
        const label = await chart.locator('svg').getAttribute('aria-label');
        assert.ok(label.endsWith(`: ${spans.map(one => one.name).join(', ')}.`), label);
    }
    await close();
});

test('a verdict stands first, its values and intervals are those of identify.json, its dots where they belong', async () => {
    const found = JSON.parse(readFileSync(join(folder, 'identify/identify.json'), 'utf8'));
    const {page, close} = await open(['identify']);
    assert.equal(await page.locator('main section').first().getAttribute('id'), 'verdict');
    assert.equal(await page.locator('#verdict p.verdict').textContent(), found.verdict);
    const circles = await page.locator('#verdict circle').evaluateAll(all => all.map(one => Number(one.getAttribute('cx'))));
    const whiskers = await page.locator('#verdict line.whisker').evaluateAll(all => all.map(one => [Number(one.getAttribute('x1')), Number(one.getAttribute('x2'))]));
    const entries = Object.entries(found.solutions[0].parameters);
    assert.equal(circles.length, entries.length);
    for (const [i, [name, one]] of entries.entries()) {
        near(parse((await rowOf(page, '#verdict table', name))[1]), one.value, 6);
        near((circles[i] - whiskers[i][0]) / (whiskers[i][1] - whiskers[i][0]), (one.value - one.low) / (one.high - one.low), 3);
    }
    assert.equal(await page.locator('h2', {hasText: 'Measured and predicted histories'}).count(), 1);
    await close();
});

test('explanations are those of diagnose.json', async () => {
    const found = JSON.parse(readFileSync(join(folder, 'diagnose/diagnose.json'), 'utf8'));
    const {page, close} = await open(['diagnose']);
    for (const one of [...found.candidates, ...found.others].filter(one => !one.alike)) {
        const row = await rowOf(page, '#verdict table', one.elements.join(' with '));
        assert.equal(row[0], found.candidates.includes(one) ? 'yes' : '');
        [one.factor].flat().forEach((factor, i) => near(parse(row[1].split(',')[i]), factor, 5));
        near(parse(row[6]), one.delta_bic, 6);
    }
    await close();
});

test('tables of modes have the frequencies of modes.csv', async () => {
    const {page, close} = await open(['modes']);
    const {mode, frequency} = columnsOf('modes/modes.csv');
    const firsts = [...new Set(mode)].map(m => frequency[mode.indexOf(m)]);
    const shown = await page.locator('#modes tbody tr').evaluateAll(rows => rows.map(row => row.querySelector('td').textContent));
    assert.equal(shown.length, firsts.length);
    shown.forEach((text, i) => near(parse(text), firsts[i]));
    await close();
});

test('the machine is drawn, moves, and obeys the keyboard', async () => {
    for (const results of [['plate'], ['modes']]) {
        const {page, close} = await open(results);
        await page.locator('.scene').scrollIntoViewIfNeeded();
        const first = await picture(page);
        assert.ok(first.colours > 30, `${first.colours} colours`);
        await page.locator('.scene').focus();
        await page.keyboard.press('ArrowRight');
        const turned = await picture(page);
        assert.notEqual(turned.mark, first.mark, 'arrow keys turn it');
        await page.keyboard.press('Home');
        assert.equal((await picture(page)).mark, first.mark, 'Home shows all again');
        await page.locator('input[aria-label="Instant"]').focus();
        for (let i = 0; i < 60; ++i) await page.keyboard.press('ArrowRight');
        assert.notEqual((await picture(page)).mark, first.mark, 'it moves');
        await page.locator('.scene').focus();
        await page.keyboard.press('Space');
        assert.equal(await page.locator('#machine button', {hasText: 'Pause'}).count(), 1, 'the space bar starts it');
        await close();
    }
});

test('a mode moves the machine by its shape', async () => {
    const {page, close} = await open(['modes']);
    const summary = JSON.parse(readFileSync(join(folder, 'modes/summary.json'), 'utf8'));
    const found = await page.evaluate(() => {
        const {view} = document.getElementById('machine');
        view.chooseMotion(2);
        view.motion.at(0.5);  // a quarter of the period
        const place = name => view.choice.structure.placeOf(view.choice.structure.points.get(name), view.motion, 0.01).toArray();
        return {node: place('tip_left'), marker: place('tiller.arm')};
    });
    const {shape} = summary.modes[2];
    const node = summary.model.nodes.tip_left.position.map((x, i) => x + 0.01 * shape.tip_left[i]);
    const body = summary.model.bodies.tiller;
    const theta = shape.tiller.slice(3).map(x => 0.01 * x), arm = body.markers.arm;
    const cross = [theta[1] * arm[2] - theta[2] * arm[1], theta[2] * arm[0] - theta[0] * arm[2], theta[0] * arm[1] - theta[1] * arm[0]];
    found.node.forEach((x, i) => assert.ok(Math.abs(x - node[i]) < 1e-9));
    // The rotation is finite here: it differs from its first order by half its square
    found.marker.forEach((x, i) => assert.ok(Math.abs(x - (body.position[i] + arm[i] + 0.01 * shape.tiller[i] + cross[i])) < 0.6 * Math.hypot(...theta) ** 2 * Math.hypot(...arm) + 1e-12));
    await close();
});

/** R(q) r by the matrix of a unit quaternion w x y z. */
function turned([w, x, y, z], [a, b, c]) {
    return [(1 - 2 * (y * y + z * z)) * a + 2 * (x * y - w * z) * b + 2 * (x * z + w * y) * c,
            2 * (x * y + w * z) * a + (1 - 2 * (x * x + z * z)) * b + 2 * (y * z - w * x) * c,
            2 * (x * z - w * y) * a + 2 * (y * z + w * x) * b + (1 - 2 * (x * x + y * y)) * c];
}

test('a run moves the machine as it was recorded', async () => {
    const {page, close} = await open(['pendulum']);
    const history = columnsOf('pendulum/history.csv');
    const {bodies} = JSON.parse(readFileSync(join(folder, 'pendulum/summary.json'), 'utf8')).model;
    const body = Object.keys(bodies).find(name => Math.max(...history[`${name}.quaternion.y`]) - Math.min(...history[`${name}.quaternion.y`]) > 0.3);
    assert.ok(body, 'a body turns far');
    const local = [0.11, -0.2, 0.35];
    for (const row of [0, 501, 1200, 1999]) {
        const at = (quantity, axes) => axes.map(axis => history[`${body}.${quantity}.${axis}`][row]);
        const position = at('position', ['x', 'y', 'z']), arm = turned(at('quaternion', ['w', 'x', 'y', 'z']), local);
        const found = await page.evaluate(([time, name, place]) => {
            const {view} = document.getElementById('machine');
            view.motion.at(time);
            return view.choice.structure.placeOf({owner: view.choice.structure.owners.get(name), local: new THREE.Vector3(...place)}, view.motion, 1).toArray();
        }, [history.time[row], body, local]);
        // Four bytes per number, and a straight line between frames two rows apart: half a step squared times the acceleration
        found.forEach((x, i) => assert.ok(Math.abs(x - position[i] - arm[i]) < 2e-5, `${body} row ${row}: ${x} is not ${position[i] + arm[i]}`));
    }
    await close();
});

test('a beam bends as the run recorded it; where it was not recorded the page says how it is bent', async () => {
    const {page, close} = await open(['beam']);
    const history = columnsOf('beam/history.csv'), row = 31;
    const found = await page.evaluate(time => {
        const {view} = document.getElementById('machine');
        view.motion.at(time);
        return {reach: view.motion.largest().shift, factor: Number(view.factor.value), points: view.motion.line('arm', 1).map(point => point.toArray()), remark: view.remark.textContent};
    }, history.time[row]);
    assert.equal(found.points.length, 11);
    assert.ok(found.reach > 1e-5 && found.factor > 0, 'a motion too small to be seen is enlarged, also where only a beam moves');
    found.points.forEach((point, station) => ['x', 'y', 'z'].forEach((axis, i) =>
        assert.ok(Math.abs(point[i] - history[`arm.station${station}.position.${axis}`][row]) < 2e-7)));
    assert.ok(Math.abs(history['arm.station5.position.z'][row] - 0.6) > 1e-5, 'it bends');
    assert.ok(!found.remark.includes('as their ends have it'));
    const text = await page.locator('body').innerText();
    assert.ok(text.includes('arm.force.z') && !text.includes('arm.station5'), 'stations are in the picture, not among the curves');
    await close();
    const other = await open(['straight']);
    assert.ok((await other.page.evaluate(() => document.getElementById('machine').view.remark.textContent)).includes('as their ends have it'));
    await other.close();
});

test('an equilibrium is drawn where static.csv has it', async () => {
    const {page, close} = await open(['static']);
    const table = columnsOf('static/static.csv');
    const found = await page.evaluate(() => {
        const {view} = document.getElementById('machine');
        view.motion.at(view.motion.duration);
        const {structure} = view.choice;
        return Object.fromEntries([...structure.owners.keys()].map(name => [name, structure.placeOf(structure.points.get(name), view.motion, 1).toArray()]));
    });
    assert.ok(Math.abs(table['middle.position.z'][0]) > 1e-4, 'it sags');
    ['x', 'y', 'z'].forEach((axis, i) => assert.ok(Math.abs(found.middle[i] - table[`middle.position.${axis}`][0]) < 1e-12));
    await close();
});

test('reduced motion keeps it still; else it plays', async () => {
    for (const [reducedMotion, text] of [['reduce', 'Play'], ['no-preference', 'Pause']]) {
        const {page, close} = await open(['modes'], {reducedMotion});
        assert.equal(await page.locator('#machine button', {hasText: new RegExp(`^${text}$`)}).count(), 1, reducedMotion);
        await close();
    }
});

test('axe finds nothing in any kind, light, dark and on a phone, where the page does not scroll sideways', async () => {
    for (const results of [['plate', 'other'], ['modes'], ['response'], ['static'], ['sweep'], ['single'], ['indices'], ['identify'], ['diagnose']])
        for (const [colorScheme, width] of [['light', 1200], ['dark', 1200], ['light', 375]]) {
            const {page, close} = await open(results, {colorScheme, width});
            const ground = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
            assert.equal(ground, colorScheme === 'dark' ? 'rgb(23, 25, 27)' : 'rgb(255, 255, 255)');
            assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), `${results} at ${width} scrolls sideways`);
            await page.evaluate(axe);
            const {violations} = await page.evaluate(() => window.axe.run(document, {resultTypes: ['violations']}));
            assert.deepEqual(violations.map(({id, nodes}) => `${id}: ${nodes[0].html}`), [], `${results} ${colorScheme} ${width}`);
            for (const canvas of await page.locator('canvas:visible').all())
                if (!(await canvas.evaluate(one => one.closest('[aria-hidden]')))) {
                    assert.equal(await canvas.getAttribute('role'), 'img');
                    assert.match(await canvas.getAttribute('aria-label'), /\d/);
                }
            await close();
        }
});
