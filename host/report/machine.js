// SPDX-License-Identifier: BSD-3-Clause
// The machine in 3-D: bodies as boxes of their inertia, elements as lines coloured by force or energy, moving as in the run
// or in a mode.
'use strict';

const kRing = 10;  // corners of a tube
const kBent = 12;  // pieces of a bent beam
/** From blue to yellow, as cividis the same to every colour vision, but lighter at its low end. */
const kMap = [[36, 86, 160], [90, 117, 145], [140, 146, 128], [197, 180, 96], [254, 226, 60]];

function mapColour(share) {
    const place = Math.min(Math.max(share, 0), 1) * (kMap.length - 1);
    const i = Math.min(Math.floor(place), kMap.length - 2);
    return kMap[i].map((value, k) => Math.round(value + (kMap[i + 1][k] - value) * (place - i)));
}

/** A tube along points; their number stays. */
class Tube {
    constructor(pieces, radius, material) {
        this.radius = radius;
        this.count = pieces + 1;
        const rings = this.count + 2;  // those at the ends have no radius: they close it
        const geometry = new THREE.BufferGeometry();
        geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3 * kRing * rings), 3));
        geometry.setAttribute('normal', new THREE.BufferAttribute(new Float32Array(3 * kRing * rings), 3));
        const index = [];
        for (let i = 0; i < rings - 1; ++i)
            for (let k = 0; k < kRing; ++k) {
                const [a, b, c, d] = [i * kRing + k, i * kRing + (k + 1) % kRing, (i + 1) * kRing + k, (i + 1) * kRing + (k + 1) % kRing];
                index.push(a, b, c, b, d, c);
            }
        geometry.setIndex(index);
        this.mesh = new THREE.Mesh(geometry, material);
        this.mesh.frustumCulled = false;
    }

    put(points) {
        const [position, normal] = [this.mesh.geometry.attributes.position, this.mesh.geometry.attributes.normal];
        const [along, side, other, out] = [0, 1, 2, 3].map(() => new THREE.Vector3());
        for (let ring = 0; ring < this.count + 2; ++ring) {
            const i = Math.min(Math.max(ring - 1, 0), this.count - 1);
            const isEnd = ring !== i + 1;
            along.subVectors(points[Math.min(i + 1, this.count - 1)], points[Math.max(i - 1, 0)]).normalize();
            side.set(0, 0, 1);
            if (Math.abs(along.z) > 0.9) side.set(1, 0, 0);
            side.cross(along).normalize();
            other.crossVectors(along, side);
            for (let k = 0; k < kRing; ++k) {
                const angle = 2 * Math.PI * k / kRing;
                out.copy(side).multiplyScalar(Math.cos(angle)).addScaledVector(other, Math.sin(angle));
                if (isEnd) normal.setXYZ(ring * kRing + k, ...along.clone().multiplyScalar(ring === 0 ? -1 : 1).toArray());
                else normal.setXYZ(ring * kRing + k, out.x, out.y, out.z);
                out.multiplyScalar(isEnd ? 0 : this.radius).add(points[i]);
                position.setXYZ(ring * kRing + k, out.x, out.y, out.z);
            }
        }
        position.needsUpdate = normal.needsUpdate = true;
    }
}

/** Cubic between two ends whose tangents have turned, as a beam without load has it. */
function bentLine(from, to, fromTangent, toTangent) {
    const points = [];
    for (let i = 0; i <= kBent; ++i) {
        const t = i / kBent;
        points.push(from.clone().multiplyScalar((1 + 2 * t) * (1 - t) ** 2).addScaledVector(to, t * t * (3 - 2 * t))
            .addScaledVector(fromTangent, t * (1 - t) ** 2).addScaledVector(toTangent, t * t * (t - 1)));
    }
    return points;
}

/** The meshes of a structure, and where they are in a motion. */
class Model3d {
    constructor(structure) {
        this.structure = structure;
        this.root = new THREE.Group();
        this.labels = [];
        this.boxes = [];
        const unit = structure.size;
        this.unit = unit;
        this.plain = new THREE.Color(theme.isDark ? '#8b9095' : '#6d7276');
        for (const body of structure.bodies) this.addBody(body, unit);
        for (const node of structure.nodes) this.addNode(node, unit);
        for (const joint of structure.joints) this.addJoint(joint, unit);
        this.elements = structure.elements.map(one => this.addElement(one, unit));
    }

    ball(radius, colour) {
        const mesh = new THREE.Mesh(new THREE.SphereGeometry(radius, 18, 12), new THREE.MeshLambertMaterial({color: colour}));
        this.root.add(mesh);
        return mesh;
    }

    addBody(body, unit) {
        const group = new THREE.Group();
        const edges = body.edges.map(edge => Math.max(edge, 0.004 * unit));
        const geometry = new THREE.BoxGeometry(...edges);
        const box = new THREE.Group();
        box.add(new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({color: theme.isDark ? '#5d86a8' : '#9dbcd4', transparent: true, opacity: 0.55, depthWrite: false})),
                new THREE.LineSegments(new THREE.EdgesGeometry(geometry), new THREE.LineBasicMaterial({color: theme.isDark ? '#a9cbe6' : '#3d6685'})));
        box.position.copy(body.centre);
        box.quaternion.copy(body.turn);
        group.add(box);
        this.boxes.push(box);
        for (const place of body.places) {
            if (place.distanceTo(body.centre) < 1e-6 * unit) continue;
            const arm = new Tube(1, 0.0025 * unit, new THREE.MeshLambertMaterial({color: theme.isDark ? '#a9cbe6' : '#5d87a6'}));
            arm.put([body.centre, place]);
            group.add(arm.mesh);
        }
        this.root.add(group);
        body.group = group;
        this.labels.push({text: body.owner.name, point: {owner: body.owner, local: body.centre}});
    }

    addNode(node, unit) {
        node.mesh = this.ball(0.006 * unit, theme.isDark ? '#c8cbce' : '#4a4e52');
        node.point = {owner: node.owner, local: new THREE.Vector3()};
        if (node.isFixed) this.addGround(node.point, unit);
        this.labels.push({text: node.owner.name, point: node.point});
    }

    addJoint(joint, unit) {
        joint.mesh = this.ball(0.011 * unit, theme.isDark ? '#e8e8e4' : '#24282b');
        if (joint.isGrounded) this.addGround(joint.point, unit);
        this.labels.push({text: joint.name, point: joint.point});
    }

    /** A cone whose tip is where the ground holds the machine. */
    addGround(point, unit) {
        const height = 0.04 * unit;
        const cone = new THREE.Mesh(new THREE.ConeGeometry(0.5 * height, height, 4), new THREE.MeshLambertMaterial({color: theme.isDark ? '#7a7f84' : '#b4b8bb'}));
        cone.rotation.x = Math.PI / 2;
        cone.position.copy(this.structure.startOf(point)).z -= height / 2;
        this.root.add(cone);
    }

    addElement(one, unit) {
        const drawn = {...one, material: new THREE.MeshLambertMaterial({color: this.plain})};
        if (one.length > 1e-6 * unit) {
            const radius = Math.min(Math.max(one.diameter / 2, 0.0045 * unit), 0.06 * unit, 0.4 * one.length);
            drawn.radius = radius;
            drawn.tube = new Tube(one.isBeam ? kBent : 1, radius, drawn.material);
            this.root.add(drawn.tube.mesh);
        } else {
            drawn.ball = new THREE.Mesh(new THREE.SphereGeometry(0.017 * unit, 20, 14), drawn.material);
            this.root.add(drawn.ball);
        }
        if (one.isGrounded) this.addGround(one.from.owner ? one.to : one.from, unit);
        this.labels.push({text: one.name, element: drawn});
        return drawn;
    }

    tangent(point, direction, motion, scale) {
        const moved = point.owner ? motion.of(point.owner.name) : null;
        return moved ? direction.clone().applyQuaternion(turnBy(moved.theta.multiplyScalar(scale))) : direction.clone();
    }

    put(motion, scale, most) {
        const s = this.structure;
        for (const {owner, group} of s.bodies) {
            const moved = motion.of(owner.name);
            group.position.copy(owner.start);
            group.quaternion.copy(owner.turn);
            if (!moved) continue;
            group.position.addScaledVector(moved.u, scale);
            group.quaternion.premultiply(turnBy(moved.theta.multiplyScalar(scale)));
        }
        for (const node of s.nodes) node.mesh.position.copy(s.placeOf(node.point, motion, scale));
        for (const joint of s.joints) joint.mesh.position.copy(s.placeOf(joint.point, motion, scale));
        for (const one of this.elements) this.putElement(one, motion, scale, most);
    }

    putElement(one, motion, scale, most) {
        const s = this.structure;
        const [from, to] = [one.from, one.to].map(end => s.placeOf(end, motion, scale));
        one.middle = from.clone().add(to).multiplyScalar(0.5);
        if (one.ball) one.ball.position.copy(one.middle);
        if (one.tube) {
            const line = motion.line(one.name, scale);
            if (line && line.length !== one.tube.count) {
                this.root.remove(one.tube.mesh);
                one.tube = new Tube(line.length - 1, one.radius, one.material);
                this.root.add(one.tube.mesh);
            }
            const direction = s.startOf(one.to).sub(s.startOf(one.from));
            if (line) one.tube.put(line);
            else if (one.isBeam && one.tube.count === kBent + 1)
                one.tube.put(bentLine(from, to, this.tangent(one.from, direction, motion, scale), this.tangent(one.to, direction, motion, scale)));
            else one.tube.put(Array.from({length: one.tube.count}, (_, i) => from.clone().lerp(to, i / (one.tube.count - 1))));
        }
        const value = motion.valueOf(one.name);
        if (value === null || !(most > 0)) one.material.color.copy(this.plain);
        else one.material.color.set(`rgb(${mapColour(value / most).join(',')})`);
    }

    labelPoint(label, motion, scale) {
        return label.element ? label.element.middle : this.structure.placeOf(label.point, motion, scale);
    }
}

/** The scene with its tools. */
class MachineView {
    constructor(section, results) {
        this.choices = results.map(result => ({result, structure: new Structure(result.model)}));
        this.scene = element('div', {class: 'scene', tabindex: '0', role: 'group', 'aria-label': 'The machine in 3-D. Arrow keys turn it, with shift they move it, plus and minus zoom, Home shows all, the space bar starts and stops the motion.'});
        this.canvas = element('canvas', {role: 'img'});
        this.readout = element('div', {class: 'readout', 'aria-hidden': 'true'});
        this.scale = element('div', {class: 'scale', 'aria-hidden': 'true'});
        this.scene.append(this.canvas, this.readout, this.scale, this.makeAxes());
        this.makeTools();
        section.append(this.choiceTools, this.scene, this.tools, this.remark);
        this.renderer = new THREE.WebGLRenderer({canvas: this.canvas, antialias: true, preserveDrawingBuffer: true});
        this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
        this.camera = new THREE.PerspectiveCamera(32, 1, 0.01, 100);
        this.camera.up.set(0, 0, 1);
        this.controls = new THREE.OrbitControls(this.camera, this.canvas);
        this.controls.enableZoom = false;
        this.controls.addEventListener('change', () => this.ask());
        this.scene.addEventListener('focusin', () => { this.controls.enableZoom = true; });
        this.scene.addEventListener('focusout', () => { this.controls.enableZoom = false; });
        this.canvas.addEventListener('pointerdown', () => this.scene.focus({preventScroll: true}));
        this.scene.addEventListener('keydown', event => this.press(event));
        new ResizeObserver(() => this.resize()).observe(this.scene);
        this.isVisible = true;
        new IntersectionObserver(entries => { this.isVisible = entries[0].isIntersecting; this.ask(); }).observe(this.scene);
        theme.watch(() => { this.build(); this.ask(); });
        const calm = window.matchMedia('(prefers-reduced-motion: reduce)');
        calm.addEventListener('change', () => { if (calm.matches) this.play(false); });
        this.time = 0;
        this.choose(0);
        this.play(!calm.matches && this.motion.duration > 0 && !this.isStatic);
    }

    /** Where x, y and z point, in a corner. */
    makeAxes() {
        const make = (tag, attributes, parent) => {
            const made = document.createElementNS('http://www.w3.org/2000/svg', tag);
            for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
            parent?.append(made);
            return made;
        };
        const svg = make('svg', {class: 'axes', viewBox: '-42 -42 84 84', 'aria-hidden': 'true'});
        this.axes = ['x', 'y', 'z'].map((name, i) => {
            const line = make('line', {x1: 0, y1: 0}, svg), text = make('text', {'text-anchor': 'middle'}, svg);
            text.textContent = name;
            return {axis: new THREE.Vector3().setComponent(i, 1), line, text};
        });
        return svg;
    }

    makeTools() {
        this.choiceTools = element('div', {class: 'tools'});
        if (this.choices.length > 1) {
            const select = element('select', {onchange: () => this.choose(Number(select.value))});
            this.choices.forEach(({result}, i) => select.append(element('option', {value: i}, result.name)));
            this.choiceTools.append(element('label', {}, 'Results', select));
        }
        this.modeSelect = element('select', {onchange: () => this.chooseMotion(Number(this.modeSelect.value))});
        this.modeLabel = element('label', {}, 'Mode', this.modeSelect);
        const views = [['Oblique', [0.75, -1.1, 0.62]], ['Along x', [-1, 0, 0]], ['Along y', [0, -1, 0]], ['From above', [0, -1e-3, 1]]];
        this.choiceTools.append(this.modeLabel, ...views.map(([name, direction]) => button(name, () => this.look(direction))));
        const names = element('input', {type: 'checkbox', onchange: () => { this.hasNames = names.checked; this.makeLabels(); this.ask(); }});
        this.boxesBox = element('input', {type: 'checkbox', onchange: () => { this.showBoxes(); this.ask(); }});
        this.boxesBox.checked = true;
        this.choiceTools.append(element('label', {}, names, 'names'), element('label', {}, this.boxesBox, 'boxes of inertia'));
        this.playButton = button('Play', () => this.play(!this.isPlaying));
        this.slider = element('input', {type: 'range', min: 0, max: 1000, value: 0, 'aria-label': 'Instant', class: 'grow', oninput: () => {
            this.play(false);
            this.time = Number(this.slider.value) / 1000 * this.motion.duration;
            this.ask();
        }});
        this.factor = element('input', {type: 'range', min: 0, max: 5, step: 0.1, value: 0, 'aria-label': 'Magnification of the motion', oninput: () => this.ask()});
        this.factorText = element('span', {});
        this.factorLabel = element('label', {}, 'motion ×', this.factor, this.factorText);
        this.tools = element('div', {class: 'tools'}, this.playButton, this.slider, this.factorLabel);
        this.remark = element('p', {class: 'remark'});
    }

    choose(index) {
        this.choice = this.choices[index];
        const {result} = this.choice;
        const names = result.kind === 'modes' ? listOf(result.summary?.modes).map((mode, i) => `${i + 1}: ${formatNumber(mode.frequency_hz, 5)} Hz`) : result.kind === 'static' ? casesOf(result) : [];
        this.modeSelect.replaceChildren(...names.map((name, i) => element('option', {value: i}, name)));
        this.modeLabel.firstChild.textContent = result.kind === 'static' ? 'Load case' : 'Mode';
        this.modeLabel.style.display = names.length > 1 || result.kind === 'modes' ? '' : 'none';
        this.chooseMotion(0);
        this.build();
        this.look([0.75, -1.1, 0.62]);
    }

    chooseMotion(index) {
        const {result, structure} = this.choice;
        const mode = result.kind === 'modes' ? listOf(result.summary?.modes)[index] : null;
        this.mode = mode;
        this.isStatic = result.kind === 'static' && casesOf(result).length > 0;
        this.motion = mode ? new ModeMotion(mode, result.lines?.[index], structure) : result.motion ? new RunMotion(result.motion, structure)
                                                                                   : this.isStatic ? new StaticMotion(result, index, structure) : new Rest();
        const {shift, angle} = this.motion.largest();
        // Modes, and motions that could not be seen, are enlarged; what turns far is shown as it is.
        const reach = Math.max(shift, angle * structure.size / 2);
        const wanted = reach > 0 ? 0.06 * structure.size / reach : 1;
        this.unitFactor = mode ? wanted : 1;
        this.factor.max = mode ? 1 : 5;
        this.factor.min = mode ? -1 : 0;
        this.factor.value = mode || wanted < 3 || angle > 0.3 ? 0 : Math.min(5, Math.log10(this.round(wanted)));
        this.time = mode ? 0.5 : this.isStatic ? this.motion.duration : 0;
        this.slider.value = this.motion.duration > 0 ? 1000 * this.time / this.motion.duration : 0;
        for (const part of [this.playButton, this.slider, this.factorLabel]) part.style.display = this.motion.duration > 0 ? '' : 'none';
        this.describe();
        this.makeScale();
        this.ask();
    }

    /** 1, 2 or 5 times a power of ten, below. */
    round(value) {
        const power = 10 ** Math.floor(Math.log10(value));
        return power * [5, 2, 1].find(step => step * power <= value * (1 + 1e-9));
    }

    describe() {
        const {result, structure} = this.choice;
        const parts = ['Bodies are drawn as the homogeneous boxes of their mass and inertia, not in their real shape. Spheres are elements between two points at the same place; cones are the ground.'];
        if (result.motion) {
            const still = [...structure.owners.values()].filter(owner => !owner.isFixed && !this.motion.tracks?.has(owner.name)).map(owner => owner.name);
            if (this.motion.every > 1) parts.push(`The motion shows one row in ${this.motion.every}: vibrations faster than that are not seen.`);
            if (still.length > 0) parts.push(`No position is recorded of ${still.slice(0, 6).join(', ')}${still.length > 6 ? ` and ${still.length - 6} more` : ''}: drawn at the start.`);
            const bent = structure.elements.filter(one => one.isBeam && !this.motion.lines?.has(one.name)).map(one => one.name);
            if (bent.length > 0) parts.push(`Beams are bent as their ends have it, without loads between: ${bent.slice(0, 6).join(', ')}${bent.length > 6 ? ` and ${bent.length - 6} more` : ''}. A run with --for-report records their shape.`);
        } else if (this.isStatic) parts.push('Shown are the displacements from the start to the equilibrium, growing in proportion.' + (structure.elements.some(one => one.isBeam) ? ' Beams are bent as their ends have it, without loads between.' : ''));
        else if (!this.mode) parts.push('These results have no motion: the machine is drawn as it starts.');
        this.remark.textContent = parts.join(' ');
        const what = this.mode ? `in a mode of ${formatNumber(this.mode.frequency_hz, 5)} Hz` : result.motion ? `moving for ${formatNumber(this.motion.duration, 4)} s` : 'at the start';
        this.canvas.setAttribute('aria-label', `The machine ${what}: ${counted(structure.bodies.length, 'body', 'bodies')}, ${counted(structure.nodes.length, 'node', 'nodes')}, ` +
                                               `${counted(structure.elements.length, 'element', 'elements')}, ${formatNumber(structure.size, 3)} m across. The tables of this page have its numbers.`);
    }

    makeScale() {
        const most = this.motion.most ?? 0;
        this.scale.replaceChildren();
        if (!(most > 0)) return;
        const canvas = element('canvas', {width: 120, height: 1});
        const drawing = canvas.getContext('2d');
        for (let i = 0; i < 120; ++i) {
            drawing.fillStyle = `rgb(${mapColour(i / 119).join(',')})`;
            drawing.fillRect(i, 0, 1, 1);
        }
        this.scale.append(element('div', {}, this.mode ? 'strain energy' : 'force of elements'), canvas,
                          element('div', {class: 'ends'}, element('span', {}, '0'), element('span', {}, this.mode ? share(most, 2) : withUnit(most, 'N', 3))));
    }

    build() {
        this.model = new Model3d(this.choice.structure);
        this.world = new THREE.Scene();
        this.world.background = new THREE.Color(theme.isDark ? '#1d2023' : '#fafaf8');
        const sun = new THREE.DirectionalLight('#ffffff', 1.7);
        sun.position.set(1, -2, 3);
        this.world.add(new THREE.HemisphereLight('#ffffff', theme.isDark ? '#555555' : '#aaaaaa', 1.9), sun, this.model.root);
        const {size} = this.choice.structure;
        const {low, high} = this.choice.structure.bounds(this.motion, this.unitFactor);
        const middle = low.clone().add(high).multiplyScalar(0.5);
        const grid = new THREE.GridHelper(1.6 * size, 16, theme.faint, theme.faint);
        grid.rotation.x = Math.PI / 2;
        grid.position.set(middle.x, middle.y, low.z - 0.045 * size);
        this.world.add(grid);
        this.showBoxes();
        this.makeLabels();
    }

    showBoxes() { for (const box of this.model.boxes) box.visible = this.boxesBox.checked; }

    makeLabels() {
        this.scene.querySelectorAll('.label').forEach(label => label.remove());
        const make = text => { const label = element('div', {class: 'label', 'aria-hidden': 'true'}, text); this.scene.append(label); return label; };
        this.labels = [];
        if (!this.hasNames) return;
        for (const label of this.model.labels.slice(0, 300))
            this.labels.push({node: make(label.text), place: () => this.model.labelPoint(label, this.motion, this.total).clone()});
    }

    look(direction) {
        const {low, high} = this.choice.structure.bounds(this.motion, this.total ?? this.unitFactor);
        const middle = low.clone().add(high).multiplyScalar(0.5);
        const towards = new THREE.Vector3(...direction).normalize();
        const right = this.camera.up.clone().cross(towards).normalize();
        const up = towards.clone().cross(right);
        const slope = Math.tan(this.camera.fov * Math.PI / 360);
        let distance = 0.2 * this.choice.structure.size;
        for (const x of [low.x, high.x]) for (const y of [low.y, high.y]) for (const z of [low.z, high.z]) {
            const corner = new THREE.Vector3(x, y, z).sub(middle);
            distance = Math.max(distance, corner.dot(towards) + Math.abs(corner.dot(right)) / slope / this.camera.aspect, corner.dot(towards) + Math.abs(corner.dot(up)) / slope);
        }
        distance *= 1.2;
        this.controls.target.copy(middle);
        this.camera.position.copy(middle).addScaledVector(towards, distance);
        this.camera.near = distance / 100;
        this.camera.far = distance * 20;
        this.camera.updateProjectionMatrix();
        this.controls.update();
        this.ask();
    }

    resize() {
        const {clientWidth: width, clientHeight: height} = this.scene;
        if (width === 0 || height === 0) return;
        this.renderer.setSize(width, height, false);
        const wasUnset = this.camera.aspect === 1;
        this.camera.aspect = width / height;
        this.camera.updateProjectionMatrix();
        if (wasUnset) this.look([0.75, -1.1, 0.62]);
        this.ask();
    }

    play(isPlaying) {
        this.isPlaying = isPlaying;
        this.playButton.textContent = isPlaying ? 'Pause' : 'Play';
        this.last = undefined;
        this.ask();
    }

    ask() {
        if (this.isAsked) return;
        this.isAsked = true;
        requestAnimationFrame(now => { this.isAsked = false; this.render(now); });
    }

    /** Seconds of the picture for the whole motion. */
    get playTime() { return this.mode || this.isStatic ? this.motion.duration : Math.min(Math.max(this.motion.duration, 6), 20); }

    render(now) {
        if (!this.isVisible) { this.last = undefined; return; }
        if (this.isPlaying && this.motion.duration > 0) {
            const passed = this.last === undefined ? 0 : Math.min((now - this.last) / 1000, 0.1);
            this.last = now;
            this.time = (this.time + passed * this.motion.duration / this.playTime) % (this.motion.duration * (1 + 1e-9));
            this.slider.value = 1000 * this.time / this.motion.duration;
        }
        this.total = this.unitFactor * 10 ** Number(this.factor.value);
        this.factorText.textContent = formatNumber(10 ** Number(this.factor.value), 2);
        this.motion.at((this.motion.times?.[0] ?? 0) + this.time);
        this.model.put(this.motion, this.total, this.motion.most ?? 0);
        this.renderer.render(this.world, this.camera);
        this.putLabels();
        this.readout.textContent = this.readoutText();
        if (this.isPlaying) this.ask();
    }

    readoutText() {
        if (this.motion.duration === 0) return '';
        const factor = 10 ** Number(this.factor.value);
        if (this.mode) return `${formatNumber(this.mode.frequency_hz, 5)} Hz`;
        if (this.isStatic) return `${share(this.time / this.motion.duration, 2)} of the displacement${factor > 1.001 ? `, × ${formatNumber(factor, 2)}` : ''}`;
        const slow = this.playTime / this.motion.duration;
        return `t = ${(this.motion.times[0] + this.time).toPrecision(4)} s${factor > 1.001 ? `, motion × ${formatNumber(factor, 2)}` : ''}` +
               `${Math.abs(slow - 1) > 0.01 ? `, ${slow > 1 ? `${formatNumber(slow, 2)} times slower` : `${formatNumber(1 / slow, 2)} times faster`}` : ''}`;
    }

    putLabels() {
        const {clientWidth: width, clientHeight: height} = this.scene;
        const taken = [];
        for (const {node, place} of this.labels) {
            const p = place().project(this.camera);
            const [x, y, half] = [(p.x + 1) / 2 * width, (1 - p.y) / 2 * height, 3.4 * node.textContent.length + 5];
            const isFree = p.z < 1 && taken.every(other => Math.abs(x - other.x) > half + other.half || Math.abs(y - other.y) > 17);
            if (isFree) taken.push({x, y, half});
            node.style.display = isFree ? '' : 'none';
            node.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, -50%)`;
        }
        const [right, up] = [0, 1].map(i => new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, i));
        for (const {axis, line, text} of this.axes) {
            const [x, y] = [axis.dot(right), -axis.dot(up)];
            line.setAttribute('x2', 24 * x);
            line.setAttribute('y2', 24 * y);
            text.setAttribute('x', 33 * x);
            text.setAttribute('y', 33 * y + 4);
        }
    }

    press(event) {
        if (event.ctrlKey || event.metaKey || event.altKey) return;
        const sideways = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[event.key];
        const actions = {'+': () => this.approach(0.85), '=': () => this.approach(0.85), '-': () => this.approach(1 / 0.85), Home: () => this.look([0.75, -1.1, 0.62]), ' ': () => this.play(!this.isPlaying)};
        if (!sideways && !actions[event.key]) return;
        event.preventDefault();
        if (!sideways) actions[event.key]();
        else if (event.shiftKey) this.shift(...sideways);
        else this.turn(...sideways);
    }

    approach(factor) {
        this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
        this.controls.update();
        this.ask();
    }

    turn(right, up) {
        const arm = this.camera.position.clone().sub(this.controls.target);
        const length = arm.length();
        const angle = Math.atan2(arm.y, arm.x) + 0.12 * right;
        const height = Math.min(Math.max(Math.asin(arm.z / length) + 0.12 * up, -1.55), 1.55);
        this.camera.position.set(Math.cos(height) * Math.cos(angle), Math.cos(height) * Math.sin(angle), Math.sin(height)).multiplyScalar(length).add(this.controls.target);
        this.controls.update();
        this.ask();
    }

    shift(right, up) {
        const step = 0.05 * this.choice.structure.size;
        const [x, y] = [0, 1].map(i => new THREE.Vector3().setFromMatrixColumn(this.camera.matrix, i));
        const way = x.multiplyScalar(-right * step).addScaledVector(y, -up * step);
        this.camera.position.add(way);
        this.controls.target.add(way);
        this.controls.update();
        this.ask();
    }
}

/** Of the results that have bodies or nodes; says so where the browser cannot draw. */
function addMachine(section, results) {
    const shown = results.filter(({model}) => entriesOf(model?.bodies).length + entriesOf(model?.nodes).length > 0);
    if (!document.createElement('canvas').getContext('webgl2')) {
        section.append(element('p', {class: 'notice'}, 'This browser has no WebGL, which the picture of the machine needs. All numbers are in the tables.'));
    } else {
        section.view = new MachineView(section, shown);
    }
    for (const result of shown) {
        const rows = entriesOf(result.model.bodies).map(([name, body]) => {
            const {edges} = boxOfInertia(body.mass, body.inertia);
            return [name, body.mass, ...vector(body.position).toArray(), ...edges];
        });
        if (rows.length === 0) continue;
        const unit = 'm';
        section.append(element('details', {}, element('summary', {}, `Bodies of ${result.name}`),
                               makeTable({caption: `Mass, position at the start and box of inertia, ${result.name}`, rows, shown: 30,
                                          columns: [{name: 'body', isText: true}, {name: 'mass', unit: 'kg'}, {name: 'x', unit}, {name: 'y', unit}, {name: 'z', unit}, {name: 'edge 1', unit}, {name: 'edge 2', unit}, {name: 'edge 3', unit}]})));
    }
}
