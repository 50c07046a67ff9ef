// SPDX-License-Identifier: BSD-3-Clause
// Where the parts of a machine are: its points at the start from the model, its motion from a run or a mode.
'use strict';

const vector = list => new THREE.Vector3(...[0, 1, 2].map(i => Number(list?.[i] ?? 0)));

/** Rows of a rotation matrix as a quaternion. */
function turnOf(rows) {
    const r = listOf(rows).length === 3 ? rows : [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    return new THREE.Quaternion().setFromRotationMatrix(new THREE.Matrix4().set(...r[0], 0, ...r[1], 0, ...r[2], 0, 0, 0, 0, 1));
}

/** Turns by a rotation vector [rad]. */
function turnBy(theta) {
    const angle = theta.length();
    return angle > 0 ? new THREE.Quaternion().setFromAxisAngle(theta.clone().divideScalar(angle), angle) : new THREE.Quaternion();
}

/** Rotation vector of a quaternion w x y z [rad], at most half a turn, behind another turn. */
function rotationVector([w, x, y, z], behind) {
    const q = new THREE.Quaternion(x, y, z, w).multiply(behind).normalize();
    if (q.w < 0) q.set(-q.x, -q.y, -q.z, -q.w);
    const axis = new THREE.Vector3(q.x, q.y, q.z);
    const sine = axis.length();
    return axis.multiplyScalar(sine > 1e-12 ? 2 * Math.atan2(sine, q.w) / sine : 2);
}

/** Eigenvalues and eigenvectors (columns) of a symmetric matrix of three rows, by Jacobi's rotations. */
function principalAxes(matrix) {
    const a = matrix.map(row => row.map(Number));
    const v = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    for (let sweep = 0; sweep < 30; ++sweep) {
        for (const [p, q] of [[0, 1], [0, 2], [1, 2]]) {
            if (Math.abs(a[p][q]) < 1e-14 * (Math.abs(a[p][p]) + Math.abs(a[q][q]))) continue;
            const angle = 0.5 * Math.atan2(2 * a[p][q], a[q][q] - a[p][p]);
            const [c, s] = [Math.cos(angle), Math.sin(angle)];
            for (let k = 0; k < 3; ++k) [a[k][p], a[k][q]] = [c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]];
            for (let k = 0; k < 3; ++k) [a[p][k], a[q][k]] = [c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]];
            for (let k = 0; k < 3; ++k) [v[k][p], v[k][q]] = [c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]];
        }
    }
    return {moments: [a[0][0], a[1][1], a[2][2]], axes: v};
}

/** The homogeneous box of the same mass and inertia: edges [m], and its axes in those of the body. */
function boxOfInertia(mass, inertia) {
    const {moments, axes} = principalAxes(inertia);
    const sum = moments[0] + moments[1] + moments[2];
    const edges = moments.map(moment => Math.sqrt(Math.max(0, 6 * (sum - 2 * moment) / mass)));
    const [x, y, z] = [0, 1, 2].map(i => new THREE.Vector3(axes[0][i], axes[1][i], axes[2][i]));
    if (new THREE.Vector3().crossVectors(x, y).dot(z) < 0) z.negate();
    return {edges, turn: new THREE.Quaternion().setFromRotationMatrix(new THREE.Matrix4().makeBasis(x, y, z))};
}

/** The machine at the start. Owners are bodies and nodes; a point belongs to one, or to the ground. */
class Structure {
    constructor(model) {
        this.owners = new Map();
        this.points = new Map();
        this.bodies = [];
        this.nodes = [];
        for (const [name, body] of entriesOf(model.bodies)) {
            const owner = {name, start: vector(body.position), turn: turnOf(body.rotation)};
            const box = boxOfInertia(body.mass, body.inertia);
            this.owners.set(name, owner);
            this.bodies.push({owner, mass: body.mass, centre: vector(body.center_of_mass), ...box, places: []});
            this.points.set(name, {owner, local: new THREE.Vector3()});
            for (const [marker, local] of entriesOf(body.markers)) this.points.set(`${name}.${marker}`, {owner, local: vector(local)});
        }
        for (const [name, node] of entriesOf(model.nodes)) {
            const owner = {name, start: vector(node.position), turn: turnOf(node.rotation), isFixed: listOf(node.fixed).length === 6};
            this.owners.set(name, owner);
            this.nodes.push({owner, isFixed: listOf(node.fixed).length > 0});
            this.points.set(name, {owner, local: new THREE.Vector3()});
        }
        this.addElements(model.elements);
        this.addJoints(model.joints);
        this.measure();
    }

    addElements(elements) {
        this.elements = [];
        for (const [name, one] of entriesOf(elements)) {
            const ends = [one.from, one.to ?? one.on ?? one.at].map(place => (typeof place === 'string' ? this.points.get(place) ?? null : null));
            const known = ends.find(Boolean);
            if (!known) continue;
            const fixed = {owner: null, local: this.startOf(known)};
            const [from, to] = ends.map(end => end ?? fixed);
            for (const body of this.bodies)
                for (const end of ends) if (end?.owner === body.owner) body.places.push(end.local);
            const length = this.startOf(from).distanceTo(this.startOf(to));
            const size = [...listOf(one.section?.tube), ...listOf(one.section?.circle), ...listOf(one.section?.rectangle)].filter(Boolean);
            this.elements.push({name, type: one.type, from, to, length, isGrounded: ends.includes(null), isBeam: one.type === 'beam', diameter: size.length ? Math.max(...size) : 0});
        }
    }

    addJoints(joints) {
        this.joints = [];
        for (const [name, joint] of entriesOf(joints)) {
            if (!Array.isArray(joint.anchor)) continue;
            const anchor = vector(joint.anchor);
            for (const place of listOf(joint.between)) {
                const body = this.bodies.find(one => one.owner.name === place);
                if (!body) continue;
                const local = anchor.clone().sub(body.owner.start).applyQuaternion(body.owner.turn.clone().invert());
                body.places.push(local);
                if (!this.joints.some(one => one.name === name)) this.joints.push({name, point: {owner: body.owner, local}, isGrounded: listOf(joint.between).includes('ground')});
            }
        }
    }

    /** Size [m] and middle of all points and boxes. */
    measure() {
        const low = new THREE.Vector3(Infinity, Infinity, Infinity), high = low.clone().negate();
        const add = point => { low.min(point); high.max(point); };
        this.corners = [...this.points.values()];
        for (const {owner, centre, edges, turn} of this.bodies)
            for (const x of [-0.5, 0.5]) for (const y of [-0.5, 0.5]) for (const z of [-0.5, 0.5])
                this.corners.push({owner, local: new THREE.Vector3(x * edges[0], y * edges[1], z * edges[2]).applyQuaternion(turn).add(centre)});
        for (const point of this.corners) add(this.startOf(point));
        this.low = low;
        this.high = high;
        this.size = Math.max(low.distanceTo(high), 1e-6);
        if (!Number.isFinite(this.size)) throw new Error('the model in summary.json has places that are no numbers');
    }

    /** Corners of what the machine fills while it moves. */
    bounds(motion, scale) {
        const low = this.low.clone(), high = this.high.clone();
        const count = motion.duration > 0 ? 40 : 0;
        for (let i = 0; i < count; ++i) {
            motion.at((motion.times?.[0] ?? 0) + motion.duration * i / count);
            for (const point of this.corners) {
                const place = this.placeOf(point, motion, scale);
                low.min(place);
                high.max(place);
            }
        }
        return {low, high};
    }

    startOf({owner, local}) {
        return owner ? local.clone().applyQuaternion(owner.turn).add(owner.start) : local.clone();
    }

    /** Where a point is: motion has displacement and rotation vector of every owner; both are multiplied by scale. */
    placeOf({owner, local}, motion, scale) {
        const moved = owner ? motion.of(owner.name) : null;
        if (!moved) return this.startOf({owner, local});
        const turned = local.clone().applyQuaternion(owner.turn).applyQuaternion(turnBy(moved.theta.clone().multiplyScalar(scale)));
        return turned.add(owner.start).addScaledVector(moved.u, scale);
    }
}

/** Nothing moves. */
class Rest {
    constructor() { this.duration = 0; }
    at() {}
    of() { return null; }
    valueOf() { return null; }
    largest() { return {shift: 0, angle: 0}; }
    line() { return null; }
}

/** The recorded motion of a run, and the forces of its elements. */
class RunMotion {
    constructor(motion, structure) {
        this.times = decodeDoubles(motion.times);
        this.every = motion.every;
        this.duration = this.times[this.times.length - 1] - this.times[0];
        this.tracks = new Map();
        for (const {name, start, turn} of structure.owners.values()) {
            const from = motion.bodies?.[name] ?? motion.nodes?.[name];
            if (!from?.position) continue;
            const position = decodeFloats(from.position);
            const u = position.map((value, i) => value - [start.x, start.y, start.z][i % 3]);
            this.tracks.set(name, {u, theta: from.quaternion ? this.rotations(decodeFloats(from.quaternion), turn) : from.rotation ? decodeFloats(from.rotation) : new Float32Array(u.length)});
        }
        this.forces = new Map(entriesOf(motion.forces).map(([name, text]) => [name, decodeFloats(text)]));
        this.lines = new Map(entriesOf(motion.lines).map(([name, text]) => [name, decodeFloats(text)]));
        this.ends = new Map(structure.elements.map(({name, from, to}) => [name, [structure.startOf(from), structure.startOf(to)]]));
        this.most = Math.max(0, ...[...this.forces.values()].map(list => list.reduce((most, value) => Math.max(most, value), 0)));
        this.at(this.times[0]);
    }

    /** Rotation vectors from the start, without jumps where a whole turn is over. */
    rotations(quaternions, start) {
        const theta = new Float32Array(quaternions.length / 4 * 3);
        const back = start.clone().invert();
        const last = new THREE.Vector3();
        for (let i = 0; i < quaternions.length / 4; ++i) {
            const found = rotationVector(quaternions.subarray(4 * i, 4 * i + 4), back);
            const angle = found.length();
            // The same turn by another angle or axis, nearest to the last row
            if (angle > 1e-9) found.addScaledVector(found, 2 * Math.PI / angle * Math.round((last.dot(found) / angle - angle) / (2 * Math.PI)));
            else if (last.length() > Math.PI) found.copy(last).setLength(2 * Math.PI * Math.round(last.length() / (2 * Math.PI)));
            last.copy(found);
            theta.set([last.x, last.y, last.z], 3 * i);
        }
        return theta;
    }

    at(time) {
        let [low, high] = [0, this.times.length - 1];
        while (high - low > 1) {
            const middle = (low + high) >> 1;
            if (this.times[middle] <= time) low = middle; else high = middle;
        }
        this.low = low;
        this.high = high;
        this.between = Math.min(1, Math.max(0, (time - this.times[low]) / (this.times[high] - this.times[low] || 1)));
    }

    mix(list, i, count) { return list[count * this.low + i] * (1 - this.between) + list[count * this.high + i] * this.between; }

    of(name) {
        const track = this.tracks.get(name);
        if (!track) return null;
        const read = list => new THREE.Vector3(this.mix(list, 0, 3), this.mix(list, 1, 3), this.mix(list, 2, 3));
        return {u: read(track.u), theta: read(track.theta)};
    }

    /** Force of an element [N]; null if it is not recorded. */
    valueOf(name) {
        const list = this.forces.get(name);
        return list ? this.mix(list, 0, 1) : null;
    }

    largest() {
        const most = list => { let found = 0; for (let i = 0; i < list.length; i += 3) found = Math.max(found, Math.hypot(list[i], list[i + 1], list[i + 2])); return found; };
        let [shift, angle] = [0, 0];
        for (const {u, theta} of this.tracks.values()) { shift = Math.max(shift, most(u)); angle = Math.max(angle, most(theta)); }
        for (const [name, list] of this.lines) {
            const [from, to] = this.ends.get(name), width = list.length / this.times.length;
            for (let i = 0; i < list.length; i += 3) {
                const start = from.clone().lerp(to, (i % width) / (width - 3));
                shift = Math.max(shift, start.distanceTo(new THREE.Vector3(list[i], list[i + 1], list[i + 2])));
            }
        }
        return {shift, angle};
    }

    /** Points along a beam as recorded; null where they are not. Their way from the straight line at the start is scaled. */
    line(name, scale) {
        const list = this.lines.get(name);
        if (!list) return null;
        const [from, to] = this.ends.get(name);
        const width = list.length / this.times.length, points = [];
        for (let i = 0; i < width; i += 3) {
            const start = from.clone().lerp(to, i / (width - 3));
            const now = new THREE.Vector3(...[0, 1, 2].map(k => this.mix(list, i + k, width)));
            points.push(start.addScaledVector(now.sub(start), scale));
        }
        return points;
    }
}

/** A natural vibration: shapes times the sine of the phase. One period lasts 2 s. */
class ModeMotion {
    constructor(mode, lines, structure) {
        this.duration = 2;
        this.shapes = new Map();
        for (const [name, shape] of entriesOf(mode.shape)) {
            const numbers = Array.isArray(shape?.[0]) ? shape[0] : shape;
            if (structure.owners.has(name)) this.shapes.set(name, {u: vector(numbers), theta: vector(listOf(numbers).slice(3))});
        }
        this.lines = new Map(entriesOf(lines).map(([name, text]) => [name, decodeFloats(text)]));
        this.energies = mode.strain_energy ?? {};
        this.most = Math.max(0, ...Object.values(this.energies));
        this.at(0.5);
    }

    at(time) { this.phase = Math.sin(Math.PI * time); }

    of(name) {
        const shape = this.shapes.get(name);
        return shape ? {u: shape.u.clone().multiplyScalar(this.phase), theta: shape.theta.clone().multiplyScalar(this.phase)} : null;
    }

    valueOf(name) { return this.energies[name] ?? (this.most > 0 ? 0 : null); }

    largest() {
        let [shift, angle] = [0, 0];
        for (const {u, theta} of this.shapes.values()) { shift = Math.max(shift, u.length()); angle = Math.max(angle, theta.length()); }
        for (const list of this.lines.values()) for (let i = 0; i < list.length; i += 6) shift = Math.max(shift, Math.hypot(list[i + 3], list[i + 4], list[i + 5]));
        return {shift, angle};
    }

    /** Points along a beam, as the mode bends it. */
    line(name, scale) {
        const list = this.lines.get(name);
        if (!list) return null;
        const points = [];
        for (let i = 0; i < list.length; i += 6)
            points.push(new THREE.Vector3(...[0, 1, 2].map(k => list[i + k] + scale * this.phase * list[i + 3 + k])));
        return points;
    }
}

const staticTable = result => listOf(result.tables).find(table => table.file === 'static.csv');

/** Names of the load cases of an equilibrium; one without a name if the model has none. */
function casesOf(result) {
    const table = staticTable(result);
    if (!table || table.rows.length === 0) return [];
    return table.columns[0].unit === '' ? table.rows.map(row => String(row[0])) : table.rows.map((_, i) => `row ${i + 1}`);
}

/** The way from the start to an equilibrium, in proportion; it takes 2 s. */
class StaticMotion {
    constructor(result, index, structure) {
        const table = staticTable(result);
        const columns = new Map(table.columns.map(({name}, c) => [name, c]));
        const read = (name, quantity, axes) => {
            const found = axes.map(axis => table.rows[index][columns.get(`${name}.${quantity}.${axis}`)]);
            return found.every(value => typeof value === 'number') ? found : null;
        };
        this.duration = 2;
        this.tracks = new Map();
        for (const {name, start, turn} of structure.owners.values()) {
            const position = read(name, 'position', ['x', 'y', 'z']);
            if (!position) continue;
            const quaternion = read(name, 'quaternion', ['w', 'x', 'y', 'z']), rotation = read(name, 'rotation', ['x', 'y', 'z']);
            const theta = quaternion ? rotationVector(quaternion, turn.clone().invert()) : vector(rotation);
            this.tracks.set(name, {u: vector(position).sub(start), theta});
        }
        this.forces = new Map();
        for (const {name} of structure.elements) {
            const force = read(name, 'force', ['x', 'y', 'z']) ?? (columns.has(`${name}.force`) ? [table.rows[index][columns.get(`${name}.force`)]] : null);
            if (force) this.forces.set(name, Math.hypot(...force));
        }
        this.most = Math.max(0, ...this.forces.values());
        this.at(this.duration);
    }

    at(time) { this.part = Math.min(time / this.duration, 1); }

    of(name) {
        const track = this.tracks.get(name);
        return track ? {u: track.u.clone().multiplyScalar(this.part), theta: track.theta.clone().multiplyScalar(this.part)} : null;
    }

    valueOf(name) { return this.forces.get(name) ?? null; }

    largest() {
        let [shift, angle] = [0, 0];
        for (const {u, theta} of this.tracks.values()) { shift = Math.max(shift, u.length()); angle = Math.max(angle, theta.length()); }
        return {shift, angle};
    }

    line() { return null; }
}
