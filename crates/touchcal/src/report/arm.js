"use strict";
// The arm, the parts and the contacts in space, by three.js. It draws when something moves, and rests otherwise.

const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const colour = (name) => new three.Color(css(name));
const RAMP = ["--ramp-0", "--ramp-1", "--ramp-2", "--ramp-3"];

const matrix = ([x, y, z, qx, qy, qz, qw]) => new three.Matrix4().compose(new three.Vector3(x, y, z), new three.Quaternion(qx, qy, qz, qw), new three.Vector3(1, 1, 1));

/** Frames of an arm at joint positions q, in base: of each joint after its motion, with its axis if it moves; then the tool's. */
function frames({ joints, tip_from_tool }, q) {
  const at = new three.Matrix4(), moving = q[Symbol.iterator](), found = [{ at: at.clone() }];
  for (const { kind, parent_from_joint, axis } of joints) {
    at.multiply(matrix(parent_from_joint));
    const along = new three.Vector3(...axis);
    if (kind === "turns") at.multiply(new three.Matrix4().makeRotationAxis(along, moving.next().value));
    if (kind === "slides") at.multiply(new three.Matrix4().makeTranslation(along.multiplyScalar(moving.next().value)));
    found.push({ at: at.clone(), axis: kind === "fixed" ? null : new three.Vector3(...axis).transformDirection(at) });
  }
  return { joints: found, tool: at.multiply(matrix(tip_from_tool)) };
}
const origin = (frame) => new three.Vector3().setFromMatrixPosition(frame);

/** Colours of distances (m) on a logarithmic scale from the fifth to the ninety-fifth in a hundred. */
function scale(distances) {
  const [low, high] = [0.05, 0.95].map((share) => Math.log(Math.max(1e-7, quantile(distances, share) ?? 1e-7)));
  const stops = RAMP.map(colour);
  return { ends: [Math.exp(low), Math.exp(high)], of(distance) {
    const share = high > low ? (Math.log(Math.max(1e-7, distance)) - low) / (high - low) : 0;
    const at = Math.min(2.999, Math.max(0, 3 * share)), k = Math.floor(at);
    return stops[k].clone().lerp(stops[k + 1], at - k);
  } };
}

class ArmView {
  constructor(host) {
    this.host = host;
    this.model = data.scene.calibrated;
    this.points = data.scene.after;
    this.is_compared = true;
    this.exaggeration = exaggeration(0.08 * this.size);
    this.chosen = Math.floor(data.scene.q.length / 2);
    this.renderer = new three.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "The arm, the parts and the contacts in space. Arrow keys rotate, plus and minus zoom, 0 shows the whole again.");
    host.append(this.canvas);
    this.world = new three.Scene();
    this.moved = new three.Group();
    this.still = new three.Group();
    this.world.add(this.moved, this.still, new three.HemisphereLight(0xffffff, 0x8090a0, 2.2));
    const sun = new three.DirectionalLight(0xffffff, 1.6);
    this.camera = new three.PerspectiveCamera(35, 1, 0.001, 100);
    this.camera.up.set(0, 0, 1);
    this.camera.add(sun.translateX(-0.4).translateY(0.8));
    this.world.add(this.camera);
    this.steer();
    this.lookAt(null);
    this.build();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.build());
    addEventListener("beforeprint", () => this.build());
    addEventListener("afterprint", () => this.build());
    new ResizeObserver(() => this.resize()).observe(host);
  }

  /** Size of things: how far the arm reaches. */
  get size() {
    return (this.reach ??= Math.max(0.1, ...[0, this.chosen].map((k) => {
      const { joints, tool } = frames(this.model, data.scene.q[k] ?? data.scene.nominal.joints.map(() => 0));
      const places = [...joints.map((joint) => origin(joint.at)), origin(tool)];
      return places.reduce((sum, place, i) => sum + (i ? place.distanceTo(places[i - 1]) : 0), 0);
    })));
  }

  steer() {
    const controls = (this.controls = new three.OrbitControls(this.camera, this.canvas));
    controls.enableZoom = false;
    // A finger that moves up or down scrolls the page; sideways it turns the arm.
    this.canvas.style.touchAction = "pan-y";
    controls.addEventListener("change", () => this.render());
    let down = null;
    this.canvas.addEventListener("pointerdown", (event) => {
      controls.enableZoom = true;
      down = [event.offsetX, event.offsetY];
    });
    this.canvas.addEventListener("pointerup", (event) => {
      if (down && Math.hypot(event.offsetX - down[0], event.offsetY - down[1]) < 4) this.pick(event.offsetX, event.offsetY);
    });
    this.canvas.addEventListener("blur", () => (controls.enableZoom = false));
    const keys = { ArrowLeft: [-0.1, 0, 1], ArrowRight: [0.1, 0, 1], ArrowUp: [0, -0.1, 1], ArrowDown: [0, 0.1, 1], "+": [0, 0, 0.9], "=": [0, 0, 0.9], "-": [0, 0, 1 / 0.9] };
    this.canvas.addEventListener("keydown", (event) => {
      if (event.key === "0") this.lookAt(null);
      const turn = keys[event.key];
      if (!turn) return;
      event.preventDefault();
      const from = this.camera.position.clone().sub(controls.target);
      const side = new three.Vector3().crossVectors(this.camera.up, from).normalize();
      const up = Math.min(Math.PI - 0.05, Math.max(0.05, from.angleTo(this.camera.up) + turn[1])) - from.angleTo(this.camera.up);
      from.applyAxisAngle(this.camera.up, turn[0]).applyAxisAngle(side, up).multiplyScalar(turn[2]);
      this.camera.position.copy(controls.target).add(from);
      controls.update();
    });
  }

  /** Turns to fixture f, or to all. */
  lookAt(f) {
    const { q, fixtures } = data.scene;
    const touching = this.points.filter((_, k) => f == null || data.contacts.drawn.fixture[k] === f).map((point) => new three.Vector3(...point));
    const arm = f == null && q.length ? [...frames(this.model, q[this.chosen]).joints.map((joint) => origin(joint.at))] : [];
    const places = [...touching, ...arm, ...fixtures.filter((part, k) => part && (f == null || k === f)).map((part) => origin(matrix(part.base_from_fixture)))];
    const middle = places.reduce((sum, place) => sum.add(place), new three.Vector3()).divideScalar(Math.max(1, places.length));
    if (f == null) {
      const [low, high] = ["min", "max"].map((side) => places.reduce((end, place) => end[side](place), (places[0] ?? middle).clone()));
      middle.addVectors(low, high).divideScalar(2);
    }
    const radius = Math.max(f == null ? 0.1 : 0.03, ...places.map((place) => place.distanceTo(middle)));
    // From the side, so that the arm bends in the picture's plane.
    const out = touching.length ? touching[0] : new three.Vector3(1, 0, 0);
    const around = Math.atan2(out.y, out.x) - 1.0;
    const from = new three.Vector3(Math.cos(around), Math.sin(around), f == null ? 0.38 : 0.6).normalize();
    const narrow = Math.min(1, (this.host.clientWidth || 1) / (this.host.clientHeight || 1));
    this.camera.position.copy(middle).addScaledVector(from, ((f == null ? 3.1 : 4.2) * radius) / narrow);
    this.controls.target.copy(middle);
    this.controls.update();
  }

  /** All anew: colours may be others, or the arm. */
  build() {
    for (const group of [this.still, this.moved]) group.clear();
    this.addFloor();
    data.scene.fixtures.filter((part) => part).forEach((part) => {
      const shape = this.shape(part.shape, colour("--part"), 0.16);
      shape.applyMatrix4(matrix(part.base_from_fixture));
      this.still.add(shape);
      if (part.shape.kind !== "point") this.still.add(this.axes(matrix(part.base_from_fixture), 0.06));
    });
    if (this.is_compared) this.addErrors();
    this.addContacts();
    this.pose(this.chosen);
  }

  addFloor() {
    const step = 0.1, cells = 2 * Math.ceil((1.1 * this.size) / step);
    const floor = new three.GridHelper(cells * step, cells, colour("--faint"), colour("--faint"));
    this.still.add(floor.rotateX(Math.PI / 2), this.axes(new three.Matrix4(), 0.16));
  }

  axes(at, length) {
    const axes = new three.AxesHelper(length * this.size).setColors("#d0312d", "#2e9e44", "#2f6fde");
    axes.applyMatrix4(at);
    return axes;
  }

  /** A part in its own frame. */
  shape(shape, paint, opacity) {
    const group = new three.Group();
    const skin = new three.MeshLambertMaterial({ color: paint, transparent: opacity < 1, opacity, depthWrite: opacity === 1, side: 2 });
    const solid = (geometry, edges) => {
      group.add(new three.Mesh(geometry, skin));
      if (edges) group.add(new three.LineSegments(new three.EdgesGeometry(geometry, 20), new three.LineBasicMaterial({ color: paint })));
    };
    if (shape.kind === "prism") {
      const outline = new three.Shape(shape.outline.map(([x, y]) => new three.Vector2(x, y)));
      solid(new three.ExtrudeGeometry(outline, { depth: shape.to - shape.from, bevelEnabled: false }).translate(0, 0, shape.from), true);
    } else if (shape.kind === "plane") {
      solid(new three.PlaneGeometry(0.5 * this.size, 0.5 * this.size), true);
    } else if (shape.kind === "ball") {
      solid(new three.SphereGeometry(shape.radius, 24, 16), false);
    }
    return group;
  }

  addContacts() {
    const { after, before, rejected } = data.contacts.drawn;
    const distances = this.points === data.scene.before ? before : after;
    const paint = (this.scale = scale(distances)), bad = colour("--bad");
    const geometry = new three.BufferGeometry();
    geometry.setAttribute("position", new three.Float32BufferAttribute(this.points.flat(), 3));
    geometry.setAttribute("color", new three.Float32BufferAttribute(distances.flatMap((distance, k) => (rejected[k] ? bad : paint.of(distance)).toArray()), 3));
    this.dot ??= (() => {
      const disc = Object.assign(document.createElement("canvas"), { width: 32, height: 32 }), pen = disc.getContext("2d");
      pen.arc(16, 16, 15, 0, 2 * Math.PI);
      pen.fillStyle = "#fff";
      pen.fill();
      return new three.CanvasTexture(disc);
    })();
    const few = this.points.length < 500;
    this.still.add(new three.Points(geometry, new three.PointsMaterial({ size: few ? 7 : 4, sizeAttenuation: false, vertexColors: true, map: this.dot, alphaTest: 0.5, transparent: true })));
    this.showScale?.(paint.ends);
  }

  /** Arrows from where the nominal arm has the tool to where the calibrated one has it, in some of the contacts, exaggerated. */
  addErrors() {
    const { before, after } = data.scene, every = Math.ceil(after.length / 60);
    const paint = new three.MeshLambertMaterial({ color: colour("--before") });
    for (let k = 0; k < after.length; k += every) {
      const to = new three.Vector3(...after[k]), from = to.clone().lerp(new three.Vector3(...before[k]), this.exaggeration);
      const length = to.distanceTo(from), tip = Math.min(0.4 * length, 0.03 * this.size);
      if (length < 1e-6) continue;
      const along = to.clone().sub(from).normalize(), part = (shape, at) => {
        const mesh = new three.Mesh(shape, paint);
        mesh.position.copy(from).addScaledVector(along, at);
        mesh.quaternion.setFromUnitVectors(new three.Vector3(0, 1, 0), along);
        this.still.add(mesh);
      };
      part(new three.CylinderGeometry(0.0012 * this.size, 0.0012 * this.size, length - tip, 6), 0.5 * (length - tip));
      part(new three.CylinderGeometry(0, 0.006 * this.size, tip, 10), length - 0.5 * tip);
    }
  }

  /** The nominal arm beside the calibrated one, whose joints are at `places` and its tool at `tool`, as far off as the arrows say. */
  addNominal(q, places, tool) {
    const nominal = frames(data.scene.nominal, q), away = (place, of) => of.clone().lerp(place, this.exaggeration);
    const ghost = [...nominal.joints.map((joint, k) => away(origin(joint.at), places[k])), away(origin(nominal.tool), tool)];
    const paint = new three.MeshLambertMaterial({ color: colour("--before"), transparent: true, opacity: 0.45 });
    ghost.slice(1).forEach((place, k) => {
      const along = place.clone().sub(ghost[k]), length = along.length();
      const ball = new three.Mesh(new three.SphereGeometry(0.011 * this.size, 16, 12), paint);
      ball.position.copy(place);
      this.moved.add(ball);
      if (length < 1e-6) return;
      const rod = new three.Mesh(new three.CylinderGeometry(0.008 * this.size, 0.008 * this.size, length, 12), paint);
      rod.position.copy(ghost[k]).addScaledVector(along, 0.5);
      rod.quaternion.setFromUnitVectors(new three.Vector3(0, 1, 0), along.normalize());
      this.moved.add(rod);
    });
  }

  /** Puts the arm into contact k of those drawn. */
  pose(k) {
    this.chosen = k;
    this.moved.clear();
    const q = data.scene.q[k] ?? data.scene.nominal.joints.map(() => 0);
    const { joints, tool } = frames(this.model, q), thick = 0.028 * this.size;
    const metal = new three.MeshLambertMaterial({ color: colour("--metal") }), drum = new three.MeshLambertMaterial({ color: colour("--part") });
    const rod = (from, to, radius, material) => {
      const along = to.clone().sub(from), length = along.length();
      if (length < 1e-6) return;
      const mesh = new three.Mesh(new three.CylinderGeometry(radius, radius, length, 24), material);
      mesh.position.copy(from).addScaledVector(along, 0.5);
      mesh.quaternion.setFromUnitVectors(new three.Vector3(0, 1, 0), along.normalize());
      this.moved.add(mesh);
    };
    const places = joints.map((joint) => origin(joint.at));
    if (this.is_compared) this.addNominal(q, places, origin(tool));
    // What holds the tool ends where the tool begins, or thinly at its frame.
    const begins = Math.max(0, ...data.scene.tools.map((shape) => (shape.kind === "prism" ? shape.to : 0)));
    rod(places.at(-1), new three.Vector3(0, 0, begins).applyMatrix4(tool), (begins ? 0.25 : 0.06) * thick, metal);
    places.slice(1).forEach((place, i) => {
      const thinner = 1 - (0.5 * i) / places.length;
      rod(places[i], place, 0.75 * thick * thinner, metal);
      const ball = new three.Mesh(new three.SphereGeometry(0.75 * thinner * thick, 24, 16), metal);
      ball.position.copy(place);
      if (joints[i + 1].axis) this.moved.add(ball);
      const axis = joints[i + 1].axis;
      if (axis) rod(place.clone().addScaledVector(axis, -1.3 * thick * thinner), place.clone().addScaledVector(axis, 1.3 * thick * thinner), 1.05 * thick * thinner, drum);
    });
    for (const kind of data.scene.tools) {
      const part = this.shape(kind, colour("--after"), 0.35);
      part.applyMatrix4(tool);
      this.moved.add(part);
    }
    this.moved.add(this.axes(tool, 0.08));
    this.names = [["base", places[0]], ["tool", origin(tool)], ...(data.fixtures.length <= 6 ? data.fixtures.flatMap(({ name }, f) => (data.scene.fixtures[f] ? [[name, origin(matrix(data.scene.fixtures[f].base_from_fixture))]] : [])) : [])];
    this.tell?.(k);
    this.render();
  }

  /** The contact nearest to where it was clicked. */
  pick(x, y) {
    const far = this.points.map((point) => {
      const [px, py] = this.onScreen(new three.Vector3(...point));
      return Math.hypot(px - x, py - y);
    });
    const nearest = far.indexOf(Math.min(...far));
    if (far[nearest] < 12) this.pose(nearest);
  }

  onScreen(place) {
    const { x, y } = place.clone().project(this.camera);
    return [((x + 1) / 2) * this.host.clientWidth, ((1 - y) / 2) * this.host.clientHeight];
  }

  resize() {
    const { clientWidth, clientHeight } = this.host;
    if (!clientWidth || !clientHeight) return;
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.renderer.setSize(clientWidth, clientHeight);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    if (!this.shown) this.lookAt(null);
    this.shown = true;
    this.render();
  }

  render() {
    const away = this.camera.position.distanceTo(this.controls.target);
    this.camera.near = away / 100;
    this.camera.far = away + 20 * this.size;
    this.camera.updateProjectionMatrix();
    this.renderer.render(this.world, this.camera);
    this.labels ??= [];
    while (this.labels.length < (this.names?.length ?? 0)) this.labels.push(this.host.appendChild(el("span", { class: "label" })));
    const taken = [];
    this.names?.forEach(([name, place], k) => {
      const [x, y] = this.onScreen(place), label = this.labels[k];
      const free = !taken.some(([tx, ty]) => Math.abs(x - tx) < 90 && Math.abs(y - ty) < 16);
      if (free) taken.push([x, y]);
      label.textContent = free ? name : "";
      label.style.transform = `translate(${Math.round(x + 8)}px, ${Math.round(y + 4)}px)`;
    });
  }
}

/** How much errors are enlarged, so that their median is at most `length` (m): 1, 2, 5 or these times a power of ten. */
function exaggeration(length) {
  const { before, after } = data.scene;
  const errors = after.map((place, k) => Math.hypot(...place.map((value, axis) => value - before[k][axis])));
  const wanted = length / Math.max(1e-6, quantile(errors, 0.5) ?? 1);
  if (!(wanted > 1)) return 1;
  const ten = 10 ** Math.floor(Math.log10(wanted));
  return ten * [5, 2, 1].find((step) => step * ten <= wanted);
}

function showArm() {
  const host = byId("arm"), { drawn, every, used, rejected } = data.contacts;
  if (!data.scene.q.length) {
    host.style.height = "auto";
    host.replaceChildren(el("p", {}, "There are no contacts to show."));
    return;
  }
  const view = new ArmView(host);
  const ends = [el("span", {}), el("span", {})];
  host.after(el("p", { class: "legend" }, "distance from touching ", ends[0], el("i", {}), ends[1]));
  view.showScale = (found) => ends.forEach((end, k) => (end.textContent = mm(found[k], 2)));
  view.showScale(view.scale.ends);

  const model = (name, words, checked) => {
    const input = el("input", { type: "radio", name: "model", value: name, checked: checked ? "" : null });
    input.addEventListener("change", () => {
      view.is_compared = name === "both";
      view.model = data.scene[name === "nominal" ? name : "calibrated"];
      view.points = name === "nominal" ? data.scene.before : data.scene.after;
      view.build();
    });
    return el("label", {}, input, words);
  };
  const turnTo = el("select", {}, el("option", { value: "" }, "everything"), ...data.fixtures.flatMap(({ name }, f) => (data.scene.fixtures[f] ? [el("option", { value: f }, name)] : [])));
  turnTo.addEventListener("change", () => view.lookAt(turnTo.value === "" ? null : Number(turnTo.value)));
  const slider = el("input", { type: "range", min: 0, max: drawn.index.length - 1, "aria-label": "contact" });
  slider.addEventListener("input", () => view.pose(Number(slider.value)));
  byId("arm-controls").append(model("both", "both arms", true), model("calibrated", "calibrated", false), model("nominal", "nominal", false), el("label", {}, "look at", turnTo), el("label", { class: "wide" }, "contact", slider));
  view.tell = (k) => {
    slider.value = k;
    const at = { file: drawn.file[k], line: drawn.line[k] };
    byId("arm-note").textContent = `Contact ${drawn.index[k] + 1} (${place(at)}) with ${data.fixtures[drawn.fixture[k]].name}: ${mm(drawn.before[k])} from contact before, ${mm(drawn.after[k])} after`
      + `${drawn.rejected[k] ? ", rejected" : ""}. ` + (every > 1 ? `${drawn.index.length} of ${used + rejected} contacts are drawn. ` : "") + (rejected ? "Magenta: rejected. " : "")
      + (view.is_compared ? `Orange: the nominal arm, and arrows from where it has the tool to where the calibrated arm has it, ${view.exaggeration === 1 ? "to scale" : `errors enlarged ${view.exaggeration} times`}. ` : "") + "Links are drawn as lines between joints.";
  };
  view.tell(view.chosen);
}

try {
  showArm();
} catch (error) {
  if (!/WebGL/i.test(error.message)) throw error;
  byId("arm").replaceChildren(el("p", {}, "The three-dimensional view needs WebGL, which this browser lacks."));
}
