// SPDX-License-Identifier: Apache-2.0
// Drapes to turn, coloured by a number of each vertex. Viewers of a page share a camera and, for
// each quantity, one range of colours, so that drapes side by side can be compared.
import { interpolateViridis } from "d3-scale-chromatic";
import {
  AmbientLight,
  BufferAttribute,
  BufferGeometry,
  Color,
  CylinderGeometry,
  DirectionalLight,
  DoubleSide,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshLambertMaterial,
  PerspectiveCamera,
  Scene,
  Vector3,
  WebGLRenderer,
  WireframeGeometry,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

const GREY = "#8a8f98"; // of what the cloth lies on
const COLOURS = Array.from({ length: 256 }, (_, i) => new Color(interpolateViridis(i / 255)));
const viewers = [];
const renderAll = () => viewers.forEach((viewer) => viewer.render());

function decode(base64, Type) {
  const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  return new Type(bytes.buffer);
}

function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

// Numbers are stored in 65,535 steps from the least to the most.
function unpack({ least, most, steps }) {
  return Float32Array.from(decode(steps, Uint16Array), (step) => least + ((most - least) * step) / 65535);
}

function findRange(name, groups) {
  const fields = groups.flat().flatMap((drape) => drape.fields.filter((field) => field.name === name));
  const least = Math.min(...fields.map((field) => field.least));
  const most = Math.max(...fields.map((field) => field.most));
  return [least, most > least ? most : least + 1];
}

// The geometry of a drape or of its body. A drape without faces has those of the first.
function makeGeometry(drape, first) {
  const geometry = new BufferGeometry();
  const positions = unpack(drape.positions);
  const Index = positions.length / 3 <= 65536 ? Uint16Array : Uint32Array;
  geometry.setAttribute("position", new BufferAttribute(positions, 3));
  geometry.setIndex(new BufferAttribute(decode(drape.faces ?? first.faces, Index), 1));
  geometry.computeVertexNormals();
  return geometry;
}

// The camera of all drapes over a disc, or of all others, and its first view.
const views = {};
function findView(drape) {
  const kind = drape.support_m ? "disc" : "free";
  if (views[kind]) return views[kind];
  const view = { from: new Vector3(0.19, -0.285, 0.22), at: new Vector3(0, 0, -0.03) };
  if (!drape.support_m) {
    const geometry = makeGeometry(drape.body ?? drape);
    geometry.computeBoundingSphere();
    const { center, radius } = geometry.boundingSphere;
    view.from.sub(view.at).setLength(3.2 * radius).add(center);
    view.at.copy(center);
  }
  view.camera = new PerspectiveCamera(38, 4 / 3, 0.01, 10);
  view.camera.up.set(0, 0, 1);
  view.camera.position.copy(view.from);
  return (views[kind] = view);
}

function colour(geometry, field, [least, most]) {
  const values = unpack(field);
  const colours = new Float32Array(3 * values.length);
  values.forEach((value, i) => {
    const step = Math.round((255 * (value - least)) / (most - least));
    COLOURS[Math.min(255, Math.max(0, step))].toArray(colours, 3 * i);
  });
  geometry.setAttribute("color", new BufferAttribute(colours, 3));
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
    this.shown = []; // of the present drape
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
    this.controls.addEventListener("change", renderAll);
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
    this.what = what;
    this.wire = element("input", { type: "checkbox" });
    this.wire.addEventListener("change", again);
    const reset = element("button", { type: "button", textContent: "first view" });
    reset.addEventListener("click", () => {
      this.view.camera.position.copy(this.view.from);
      this.controls.update();
      renderAll();
    });
    this.legend = element("p", { className: "ramp" });
    this.canvas.addEventListener("keydown", (event) => this.turn(event));
    place.append(
      element("div", { className: "tools" }, ...(this.drapes.length > 1 ? [whichLabel] : []), whatLabel,
              element("label", {}, this.wire, " edges"), reset),
      this.canvas, this.legend);
  }

  // Arrow keys, for those without a mouse.
  turn(event) {
    const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.02], ArrowDown: [0, -0.02] }[event.key];
    if (!step) return;
    event.preventDefault();
    const { position } = this.view.camera;
    const { x, y } = position;
    position.x = x * Math.cos(step[0]) - y * Math.sin(step[0]);
    position.y = x * Math.sin(step[0]) + y * Math.cos(step[0]);
    position.z += step[1];
    this.controls.update();
    renderAll();
  }

  show() {
    const drape = this.drapes[Number(this.which.value)];
    const field = drape.fields[Number(this.what.value)];
    const range = findRange(field.name, this.groups);
    const geometry = makeGeometry(drape, this.drapes[0]);
    colour(geometry, field, range);
    for (const shown of this.shown) {
      this.scene.remove(shown);
      shown.geometry.dispose();
    }
    const cloth = new Mesh(geometry, new MeshLambertMaterial({ vertexColors: true, side: DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 }));
    const edges = new LineSegments(new WireframeGeometry(geometry), new LineBasicMaterial({ color: "black", transparent: true, opacity: 0.35 }));
    edges.visible = this.wire.checked;
    this.shown = [cloth, edges];
    // Further back than the cloth, from which it is less than a millimetre away.
    if (drape.body) this.shown.push(new Mesh(makeGeometry(drape.body), new MeshLambertMaterial({ color: GREY, polygonOffset: true, polygonOffsetFactor: 8, polygonOffsetUnits: 8 })));
    this.scene.add(...this.shown);
    this.canvas.setAttribute("aria-label", `The drape ${drape.name} in three dimensions, coloured by ${field.name}; arrow keys turn it`);
    const digits = Math.min(6, Math.max(0, 2 - Math.floor(Math.log10(range[1] - range[0]))));
    const [low, high] = range.map((value) => Number(value.toFixed(digits)));
    this.legend.replaceChildren(element("span", { textContent: `${low}` }), element("i"), element("span", { textContent: `${high} ${field.unit}` }));
    this.resize();
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

  // Pixels that are not empty, for tests.
  countDrawn() {
    const gl = this.renderer.getContext();
    const pixels = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
    gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    let count = 0;
    for (let i = 3; i < pixels.length; i += 4) if (pixels[i] > 0) ++count;
    return count;
  }
}

export function showDrapes(place, drapes, groups) {
  const viewer = new Viewer(place, drapes, groups);
  viewers.push(viewer);
  viewer.render();
  viewer.canvas.dataset.drawn = String(viewer.countDrawn());
}
