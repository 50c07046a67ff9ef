// SPDX-License-Identifier: BSD-3-Clause
// The part of three.js that machine.js uses.
export {
    AmbientLight, BoxGeometry, BufferAttribute, BufferGeometry, Color, ConeGeometry, CylinderGeometry, DirectionalLight,
    DoubleSide, EdgesGeometry, Float32BufferAttribute, GridHelper, Group, HemisphereLight, Line, LineBasicMaterial,
    LineSegments, Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, PerspectiveCamera, Quaternion, Raycaster, Scene,
    SphereGeometry, Vector2, Vector3, WebGLRenderer
} from 'three';
export { OrbitControls } from 'three/addons/controls/OrbitControls.js';
