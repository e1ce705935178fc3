// SPDX-License-Identifier: Apache-2.0
// Drapes to turn and to play, coloured by a number of each vertex. Viewers of a page share a camera,
// a clock and, for each quantity, one range of colours, so that drapes side by side can be compared.
import { interpolateViridis } from "d3-scale-chromatic";
import {
  AmbientLight, AnimationClip, Box3, BufferAttribute, BufferGeometry, Color, CylinderGeometry,
  DirectionalLight, DoubleSide, Group, Mesh, MeshBasicMaterial, MeshLambertMaterial,
  MeshStandardMaterial, NumberKeyframeTrack, PerspectiveCamera, Scene, Sphere, Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { GLTFExporter } from "three/addons/exporters/GLTFExporter.js";

const GREY = "#8a8f98"; // of what the cloth lies on
const COLOURS = Array.from({ length: 256 }, (_, i) => new Color(interpolateViridis(i / 255)));
const viewers = [];

// The motions of the page play in step.
const clock = { time: Infinity, end: 0, last: 0, playing: false }; // [s]; last [ms]: the frame of the screen
function setClock(time, playing) {
  Object.assign(clock, { time, playing });
  viewers.forEach((viewer) => viewer.move());
}
function tick(now) {
  if (!clock.playing) return;
  setClock((Math.min(clock.time, clock.end) + (now - clock.last) / 1000) % clock.end, true);
  clock.last = now;
  requestAnimationFrame(tick);
}

function decode(base64, Type) {
  const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  return new Type(bytes.buffer);
}

function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

// Numbers are stored in equal steps from the least to the most: positions in 65,535, fields in 255.
function unpack({ least, most, steps }, Type) {
  const step = (most - least) / (256 ** Type.BYTES_PER_ELEMENT - 1);
  return Float32Array.from(decode(steps, Type), (count) => least + step * count);
}

// The numbers of all vertices at the present time, between two frames.
function sample(values, times) {
  const size = values.length / times.length;
  const k = times.findLastIndex((time) => time <= Math.max(clock.time, times[0]));
  const from = values.subarray(k * size, (k + 1) * size);
  if (k + 1 === times.length) return from;
  const share = Math.max(0, clock.time - times[k]) / (times[k + 1] - times[k]);
  return from.map((value, i) => value + share * (values[from.length * (k + 1) + i] - value));
}

function findRange(name, groups) {
  const fields = groups.flat().flatMap((drape) => drape.fields.filter((field) => field.name === name));
  const least = Math.min(...fields.map((field) => field.least));
  const most = Math.max(...fields.map((field) => field.most));
  return [least, most > least ? most : least + 1];
}

// A cloth or a body: the positions of its frames, and a mesh of the present time.
class Figure {
  constructor({ positions, faces }, times, name, material) {
    this.times = times;
    this.positions = unpack(positions, Uint16Array);
    this.size = this.positions.length / times.length;
    const Index = this.size / 3 <= 65536 ? Uint16Array : Uint32Array;
    const geometry = new BufferGeometry().setIndex(new BufferAttribute(decode(faces, Index), 1));
    for (const attribute of ["position", "color"])
      geometry.setAttribute(attribute, new BufferAttribute(new Float32Array(this.size), 3));
    this.mesh = new Mesh(geometry, material);
    this.mesh.name = name;
  }

  move() {
    const { geometry } = this.mesh;
    geometry.attributes.position.copyArray(sample(this.positions, this.times)).needsUpdate = true;
    geometry.computeVertexNormals();
    geometry.computeBoundingSphere();
  }

  // A mesh with a morph target for each frame but the first, and the track that moves it.
  makeMorph() {
    const { index } = this.mesh.geometry;
    const [first, ...others] = this.times.map(
      (_, k) => new BufferAttribute(this.positions.slice(k * this.size, (k + 1) * this.size), 3));
    const geometry = new BufferGeometry().setIndex(index).setAttribute("position", first);
    geometry.morphAttributes.position = others;
    const mesh = new Mesh(geometry, new MeshStandardMaterial({ color: this.mesh.material.color, side: DoubleSide }));
    mesh.name = this.mesh.name;
    const weights = this.times.flatMap((_, k) => others.map((_, target) => Number(target + 1 === k)));
    return [mesh, new NumberKeyframeTrack(`${mesh.name}.morphTargetInfluences`, this.times, weights)];
  }
}

// The camera of all drapes over a disc, or of all others, and its first view.
const views = {};
function findView(drape) {
  const kind = drape.support_m ? "disc" : "free";
  if (views[kind]) return views[kind];
  const view = { from: new Vector3(0.19, -0.285, 0.22), at: new Vector3(0, 0, -0.03) };
  if (!drape.support_m) {
    const positions = unpack((drape.body ?? drape).positions, Uint16Array);
    const last = new Box3().setFromArray(positions.subarray(-positions.length / drape.times.length));
    const { center, radius } = last.getBoundingSphere(new Sphere());
    view.from.sub(view.at).setLength(3 * radius).add(center);
    view.at.copy(center);
  }
  view.camera = new PerspectiveCamera(38, 4 / 3, 0.01, 10);
  view.camera.up.set(0, 0, 1);
  view.camera.position.copy(view.from);
  return (views[kind] = view);
}

function colour(colours, values, [least, most]) {
  values.forEach((value, i) => {
    const step = Math.round((255 * (value - least)) / (most - least));
    COLOURS[Math.min(255, Math.max(0, step))].toArray(colours.array, 3 * i);
  });
  colours.needsUpdate = true;
}

function button(textContent, onClick) {
  const made = element("button", { type: "button", textContent });
  made.addEventListener("click", onClick);
  return made;
}

function select(label, names, onChange) {
  const list = element("select");
  names.forEach((name, i) => list.append(element("option", { value: i, textContent: name })));
  list.addEventListener("change", onChange);
  return [list, element("label", {}, `${label} `, list)];
}

class Viewer {
  constructor(place, drapes, groups) {
    this.drapes = drapes;
    this.view = findView(drapes[0]);
    this.groups = groups.filter((group) => findView(group[0]) === this.view); // those that are compared
    this.canvas = element("canvas", { tabIndex: 0 });
    this.canvas.setAttribute("role", "img");
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    this.scene = new Scene();
    this.figures = []; // cloth and body of the present drape
    const sun = new DirectionalLight("white", 2.2);
    sun.position.set(0.5, -0.4, 1);
    this.scene.add(new AmbientLight("white", 1.5), sun);
    if (drapes[0].support_m) this.addSupport(drapes[0].support_m);
    this.build(place);
    this.controls = new OrbitControls(this.view.camera, this.canvas);
    this.controls.target.copy(this.view.at);
    this.controls.enablePan = false;
    this.controls.minDistance = 0.15;
    this.controls.maxDistance = Math.max(1.5, 2 * this.view.from.distanceTo(this.view.at));
    this.controls.saveState(); // for "first view"
    this.controls.addEventListener("change", () => viewers.forEach((viewer) => viewer.render()));
    this.controls.update();
    this.show();
    new ResizeObserver(() => this.resize()).observe(this.canvas);
  }

  // A little smaller, so that it does not show between the vertices of a coarse cloth.
  addSupport(supportRadius) {
    const height = 0.012;
    const radius = 0.97 * supportRadius;
    const disc = new Mesh(new CylinderGeometry(radius, radius, height, 64), new MeshLambertMaterial({ color: GREY }));
    disc.rotation.x = Math.PI / 2;
    disc.position.z = -height / 2 - 0.002;
    this.scene.add(disc);
  }

  build(place) {
    const again = () => this.show();
    const [which, whichLabel] = select("drape", this.drapes.map((drape) => drape.name), again);
    const [what, whatLabel] = select("colour", this.drapes[0].fields.map((field) => field.name), again);
    this.which = which;
    which.value = place.dataset.first;
    this.what = what;
    this.wire = element("input", { type: "checkbox" });
    this.wire.addEventListener("change", again);
    const reset = button("first view", () => this.controls.reset());
    this.play = button("play", () => {
      setClock(clock.time, !clock.playing);
      clock.last = performance.now();
      requestAnimationFrame(tick);
    });
    this.slider = element("input", { type: "range", min: 0, max: clock.end, step: 0.01 });
    this.slider.addEventListener("input", () => setClock(Number(this.slider.value), false));
    this.time = element("span");
    const player = [this.play, element("label", {}, "time ", this.slider), this.time];
    this.legend = element("p", { className: "ramp" });
    this.canvas.addEventListener("keydown", (event) => this.turn(event));
    place.append(
      element("div", { className: "tools" }, ...(this.drapes.length > 1 ? [whichLabel] : []), whatLabel,
              element("label", {}, this.wire, " edges"), reset, button("download GLB", () => this.download())),
      this.canvas, element("div", { className: "tools" }, ...(this.drapes[0].times.length > 1 ? player : [])),
      this.legend);
  }

  // Arrow keys, for those without a mouse.
  turn(event) {
    const [left, up] = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.05], ArrowDown: [0, -0.05] }[event.key] ?? [];
    if (left === undefined) return;
    event.preventDefault();
    this.controls.rotateLeft(left);
    this.controls.rotateUp(up);
  }

  show() {
    const drape = this.drapes[Number(this.which.value)];
    const field = drape.fields[Number(this.what.value)];
    const range = findRange(field.name, this.groups);
    for (const { mesh } of this.figures) {
      this.scene.remove(mesh);
      mesh.geometry.dispose();
    }
    this.figures = [new Figure(drape, drape.times, "cloth", new MeshLambertMaterial({ vertexColors: true, side: DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 }))];
    // Further back than the cloth, from which it is less than a millimetre away.
    if (drape.body) this.figures.push(new Figure(drape.body, drape.times, "body", new MeshLambertMaterial({ color: GREY, polygonOffset: true, polygonOffsetFactor: 8, polygonOffsetUnits: 8 })));
    const { mesh } = this.figures[0];
    if (this.wire.checked) mesh.add(new Mesh(mesh.geometry, new MeshBasicMaterial({ color: "black", wireframe: true, transparent: true, opacity: 0.2 })));
    this.scene.add(...this.figures.map((figure) => figure.mesh));
    const values = unpack(field, Uint8Array);
    this.colour = () => colour(mesh.geometry.attributes.color, sample(values, drape.times), range);
    this.canvas.setAttribute("aria-label", `The drape ${drape.name} in three dimensions, coloured by ${field.name}; arrow keys turn it`);
    const digits = Math.min(6, Math.max(0, 2 - Math.floor(Math.log10(range[1] - range[0]))));
    const [low, high] = range.map((value) => Number(value.toFixed(digits)));
    this.legend.replaceChildren(element("span", { textContent: `${low}` }), element("i"), element("span", { textContent: `${high} ${field.unit}` }));
    this.move();
    this.resize();
  }

  // To the present time.
  move() {
    this.figures.forEach((figure) => figure.move());
    this.colour();
    this.slider.value = Math.min(clock.time, clock.end);
    this.time.textContent = `${Number(this.slider.value).toFixed(2)} s`;
    this.play.textContent = clock.playing ? "pause" : "play";
    this.render();
  }

  // Cloth and body as a binary glTF file, in metres, with y up.
  async download() {
    const { name, times } = this.drapes[Number(this.which.value)];
    const morphs = this.figures.map((figure) => figure.makeMorph());
    const group = new Group().add(...morphs.map(([mesh]) => mesh));
    group.rotation.x = -Math.PI / 2;
    const clip = new AnimationClip(name, -1, morphs.map(([, track]) => track));
    const glb = await new GLTFExporter().parseAsync(group, { binary: true, animations: times.length > 1 ? [clip] : [] });
    const href = URL.createObjectURL(new Blob([glb], { type: "model/gltf-binary" }));
    element("a", { href, download: `${name}.glb` }).click();
    setTimeout(() => URL.revokeObjectURL(href), 60000);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0) return;
    this.renderer.setSize(width, height, false);
    this.render();
  }

  render() {
    const { camera } = this.view;
    camera.aspect = this.canvas.clientWidth / Math.max(1, this.canvas.clientHeight);
    camera.updateProjectionMatrix();
    this.renderer.render(this.scene, camera);
  }
}

export function showDrapes(place, drapes, groups) {
  clock.end = Math.max(...groups.flat().map((drape) => drape.times.at(-1)));
  viewers.push(new Viewer(place, drapes, groups));
}
