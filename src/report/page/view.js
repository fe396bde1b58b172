// The 3-D view: input and output side by side with a common camera, layers of colours, things to show, places to fly to.
import { Box3, BufferAttribute, BufferGeometry, PerspectiveCamera, Points, PointsMaterial, Raycaster, Scene, Vector2, Vector3,
  WebGLRenderer } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { makeMaterial, makeMesh, makeSegments, unpackCage, unpackModel } from "./surface.js";

const flightSeconds = 0.6;
const halfView = 14; // degrees, of the shorter side of a view
const closeUp = 0.15; // width of what a place is shown with, of the diagonal

function element(kind, properties = {}, ...children) {
  const made = Object.assign(document.createElement(kind), properties);
  made.append(...children);
  return made;
}

function text(value) {
  return Number(value.toPrecision(3)).toString();
}

class View {
  constructor(data, figure) {
    this.data = data;
    this.models = data.models.map(unpackModel);
    // Throws where there is no WebGL: the picture stays.
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.outputColorSpace = "srgb-linear"; // colours are sRGB all the way
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.autoClear = false;
    this.material = makeMaterial(data);
    this.shown = {};
    this.sides = this.models.map((model) => this.makeSide(model));
    this.box = new Box3();
    for (const side of this.sides) this.box.expandByObject(side.mesh);
    this.diagonal = this.box.getSize(new Vector3()).length() || 1;
    this.makeCamera();
    this.makePage(figure);
    new ResizeObserver(() => this.resize()).observe(this.canvas);
    this.resize();
    this.lookAtAll();
    this.chooseLayer(this.layers[0]);
  }

  makeSide(model) {
    const side = { model, scene: new Scene(), mesh: makeMesh(model, this.material) };
    side.scene.add(side.mesh);
    this.show(side, "sharp and free edges", makeSegments(model.lines.points, model.lines.segments, 0x15181c), true);
    if (model === this.models.at(-1) && this.data.cage) {
      const cage = unpackCage(this.data.cage);
      this.show(side, "control mesh", makeSegments(cage.points, cage.edges, 0x8a5fc0), false);
      if (cage.extraordinary.length > 0)
        this.show(side, "extraordinary vertices", this.makeDots(cage.extraordinary, 0xd9418c, 9), false);
    }
    if (this.data.places)
      this.show(side, "places to look at", this.makeDots(new Float32Array(this.data.places.flat()), 0xd01c1c, 7), true);
    return side;
  }

  show(side, name, object, visible) {
    object.visible = visible;
    (this.shown[name] ??= []).push(object);
    side.scene.add(object);
  }

  /** Seen through the surface, so that none is missed. */
  makeDots(points, color, size) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(points, 3));
    const material = new PointsMaterial({ color, size: size * this.renderer.getPixelRatio(), sizeAttenuation: false, depthTest: false });
    const dots = new Points(geometry, material);
    dots.renderOrder = 1;
    return dots;
  }

  makeCamera() {
    this.canvas = this.renderer.domElement;
    this.camera = new PerspectiveCamera(2 * halfView, 1, 1, 10);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = false;
    this.controls.addEventListener("change", () => this.render());
  }

  lookAtAll() {
    const { target } = this.controls;
    this.box.getCenter(target);
    const away = new Vector3(-0.55, -0.8, 0.6).normalize();
    const right = new Vector3().crossVectors(this.camera.up, away).normalize();
    const up = new Vector3().crossVectors(away, right);
    // So far that all points are within the view, whose shorter side has the angle.
    const { width, height } = this.area(0);
    const tangent = Math.tan((halfView * Math.PI) / 180) / Math.min(1, width / height);
    const point = new Vector3();
    let distance = 0;
    for (const { points } of this.models) {
      for (let i = 0; i < points.length; i += 3) {
        point.fromArray(points, i).sub(target);
        const aside = Math.max((Math.abs(point.dot(right)) * height) / width, Math.abs(point.dot(up)));
        distance = Math.max(distance, point.dot(away) + aside / tangent);
      }
    }
    this.camera.position.copy(target).addScaledVector(away, 1.05 * distance);
    this.controls.update();
  }

  makePage(figure) {
    const hasDeviation = this.models.some((model) => model.hasDeviation);
    this.layers = [
      ...(hasDeviation ? [{ name: "deviation", number: 1 }, { name: "normal angle", number: 2 }] : []),
      { name: "patches", number: 4 }, { name: "curvature", number: 3 }, { name: "zebra stripes", number: 5 }, { name: "plain", number: 0 },
    ];
    const radios = this.layers.map((layer, i) => this.option("radio", layer.name, i === 0, () => this.chooseLayer(layer)));
    const boxes = Object.entries(this.shown).map(([name, objects]) => this.option("checkbox", name, objects[0].visible, (on) => {
      for (const object of objects) object.visible = on;
      this.render();
    }));
    const all = element("button", { type: "button", textContent: "show all", onclick: () => { this.lookAtAll(); this.render(); } });
    this.titles = element("div");
    this.scale = element("div", { className: "scale" });
    this.readout = element("div", { className: "readout", textContent: "Drag to turn, wheel to zoom, click for figures." });
    this.frame = element("div", { className: "view" },
      element("div", { className: "controls" }, element("fieldset", {}, ...radios), element("fieldset", {}, ...boxes), all),
      this.titles, this.canvas, this.scale, this.readout);
    figure.replaceChildren(this.frame);
    this.listenToClicks();
    document.querySelectorAll(".places li").forEach((item, i) => {
      const button = element("button", { type: "button", textContent: item.textContent, onclick: () => this.flyTo(i, button) });
      item.replaceChildren(button);
    });
  }

  option(type, name, checked, change) {
    const input = element("input", { type, name: type === "radio" ? "layer" : name, value: name, checked, onchange: () => change(input.checked) });
    return element("label", {}, input, " " + name);
  }

  chooseLayer(layer) {
    this.material.uniforms.layer.value = layer.number;
    const perUnit = this.data.mmPerUnit;
    const angles = this.models.flatMap((model) => [model.angle.reduce((a, b) => Math.max(a, b), 0)]);
    const angleScale = Math.max(...angles, 1e-3);
    this.material.uniforms.angleScale.value = angleScale;
    const css = (colours) => `linear-gradient(to right, ${colours.map(([r, g, b]) => `rgb(${255 * r} ${255 * g} ${255 * b})`).join(",")})`;
    const ends = this.data.colours;
    const curvature = this.data.models[0].curvature.high * perUnit;
    const scales = {
      1: ["0", `${text(this.material.uniforms.deviationScale.value / perUnit)} ${this.data.unit} or more`, css(ends)],
      2: ["0", `${text((angleScale * 180) / Math.PI)} degrees`, css(ends)],
      3: [`bends away ${text(-curvature)}`, `${text(curvature)} 1/${this.data.unit} bends towards the eye`, css([ends[0], [0.93, 0.93, 0.93], ends[4]])],
    }[layer.number];
    this.scale.replaceChildren();
    if (scales) {
      const bar = element("i");
      bar.style.background = scales[2];
      this.scale.append(scales[0], bar, scales[1]);
      if (layer.number === 1) this.scale.append(this.scaleChoice());
    }
    this.render();
  }

  /** From the tolerance down to a hundredth of it. */
  scaleChoice() {
    const { deviationScale } = this.material.uniforms;
    const slider = element("input", { type: "range", min: -2, max: 0, step: 0.05, value: Math.log10(deviationScale.value / this.data.scale), title: "deviation that is red" });
    slider.oninput = () => {
      deviationScale.value = this.data.scale * 10 ** slider.value;
      this.scale.childNodes[2].textContent = `${text(deviationScale.value / this.data.mmPerUnit)} ${this.data.unit} or more`;
      this.render();
    };
    return slider;
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    this.stacked = width < 640;
    const names = this.sides.map((side) => side.model.name);
    const titles = this.stacked && names.length > 1 ? [`${names[0]} above, ${names[1]} below`] : names;
    this.titles.className = titles.length > 1 ? "titles" : "titles single";
    this.titles.replaceChildren(...titles.map((textContent) => element("span", { textContent })));
    this.renderer.setSize(width, height, false);
    this.render();
  }

  /** Where a side is drawn, in the page's pixels from the canvas's upper left corner. */
  area(number) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const count = this.sides.length;
    return this.stacked ? { x: 0, y: (number * height) / count, width, height: height / count }
      : { x: (number * width) / count, y: 0, width: width / count, height };
  }

  render() {
    const distance = this.camera.position.distanceTo(this.controls.target);
    this.camera.near = Math.max(distance - this.diagonal, distance / 100);
    this.camera.far = distance + this.diagonal;
    this.renderer.setScissorTest(true);
    this.sides.forEach((side, i) => {
      const { x, y, width, height } = this.area(i);
      const bottom = this.canvas.clientHeight - y - height;
      this.camera.aspect = width / height;
      // So that the model fits into areas that are higher than wide as well.
      const half = Math.tan((halfView * Math.PI) / 180) / Math.min(1, this.camera.aspect);
      this.camera.fov = (360 / Math.PI) * Math.atan(half);
      this.camera.updateProjectionMatrix();
      this.renderer.setViewport(x, bottom, width, height);
      this.renderer.setScissor(x, bottom, width, height);
      this.renderer.clear();
      this.renderer.render(side.scene, this.camera);
    });
  }

  listenToClicks() {
    let start = null;
    this.canvas.addEventListener("pointerdown", (event) => { start = [event.clientX, event.clientY]; });
    this.canvas.addEventListener("pointerup", (event) => {
      if (start && Math.hypot(event.clientX - start[0], event.clientY - start[1]) < 4) this.tell(event);
      start = null;
    });
  }

  /** The figures of what was clicked. */
  tell(event) {
    const frame = this.canvas.getBoundingClientRect();
    const [px, py] = [event.clientX - frame.left, event.clientY - frame.top];
    const number = this.sides.findIndex((_, i) => {
      const { x, y, width, height } = this.area(i);
      return px >= x && px < x + width && py >= y && py < y + height;
    });
    if (number < 0) return;
    const { x, y, width, height } = this.area(number);
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2((2 * (px - x)) / width - 1, 1 - (2 * (py - y)) / height), this.camera);
    const hit = ray.intersectObject(this.sides[number].mesh)[0];
    if (!hit) return;
    const { model } = this.sides[number];
    const vertex = [hit.face.a, hit.face.b, hit.face.c].reduce((a, b) => (this.gap(model, a, hit.point) < this.gap(model, b, hit.point) ? a : b));
    const perUnit = this.data.mmPerUnit;
    const place = hit.point.toArray().map((c) => text(c / perUnit)).join(", ");
    const figures = model.hasDeviation ? `deviation ${text(model.deviation[vertex] / perUnit)} ${this.data.unit}, normal angle ` +
      `${text((model.angle[vertex] * 180) / Math.PI)} degrees, ` : "";
    this.readout.textContent = `${model.name}, face ${model.faces[vertex]} at (${place}): ${figures}mean curvature ` +
      `${text(model.curvature[vertex] * perUnit)} 1/${this.data.unit}`;
  }

  gap(model, vertex, point) {
    return point.distanceToSquared(new Vector3().fromArray(model.points, 3 * vertex));
  }

  /** Looks at a place from where the surface there faces. */
  flyTo(number, button) {
    document.querySelectorAll(".places button").forEach((other) => other.setAttribute("aria-current", other === button));
    const place = new Vector3(...this.data.places[number]);
    const { model } = this.sides.at(-1);
    let nearest = 0;
    for (let i = 1; i < model.points.length / 3; ++i)
      if (this.gap(model, i, place) < this.gap(model, nearest, place)) nearest = i;
    const normal = new Vector3().fromArray(model.normals, 3 * nearest);
    const now = this.camera.position.clone().sub(this.controls.target).normalize();
    const away = normal.addScaledVector(now, 0.5).normalize();
    const end = { target: place, position: place.clone().addScaledVector(away, closeUp * 2 * this.diagonal) };
    const start = { target: this.controls.target.clone(), position: this.camera.position.clone() };
    const seconds = matchMedia("(prefers-reduced-motion: reduce)").matches ? 0 : flightSeconds;
    const begin = performance.now();
    const step = (time) => {
      const share = seconds > 0 ? Math.min(Math.max((time - begin) / (1000 * seconds), 0), 1) : 1;
      const eased = share * share * (3 - 2 * share);
      this.controls.target.lerpVectors(start.target, end.target, eased);
      this.camera.position.lerpVectors(start.position, end.position, eased);
      this.controls.update();
      this.render();
      if (share < 1) requestAnimationFrame(step);
      else this.frame.dataset.place = number;
    };
    requestAnimationFrame(step);
    this.frame.scrollIntoView({ block: "nearest" });
  }
}

export function startView(data) {
  const figure = document.getElementById("view");
  try {
    new View(data, figure);
    figure.dataset.view = "ready";
  } catch (error) {
    figure.dataset.view = "none"; // no WebGL
    console.warn(`no 3-D view: ${error.message}`);
  }
}
