// A model of the page's data as what three.js draws, and the shader of the layers.
import { BufferAttribute, BufferGeometry, Color, DoubleSide, LineBasicMaterial, LineSegments, Mesh, ShaderMaterial } from "three";

function unpack(text, Kind) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Kind(bytes.buffer);
}

function unpackRange(range) {
  return Float32Array.from(unpack(range.steps, Uint16Array), (step) => range.low + ((range.high - range.low) * step) / 65535);
}

function unpackPoints(points) {
  const steps = unpack(points.steps, Uint16Array);
  return Float32Array.from(steps, (step, i) => points.low[i % 3] + ((points.high[i % 3] - points.low[i % 3]) * step) / 65535);
}

/** Neighbouring numbers get colours that are far apart: hues by the golden angle. */
function faceColours(faces) {
  const colours = new Float32Array(3 * faces.length);
  const colour = new Color();
  faces.forEach((face, i) => {
    colour.setHSL((face * 0.61803398875) % 1, 0.45, 0.5 + 0.14 * (face % 3));
    colour.toArray(colours, 3 * i);
  });
  return colours;
}

export function unpackModel(model) {
  const points = unpackPoints(model.points);
  const zeros = () => new Float32Array(points.length / 3);
  return {
    name: model.name,
    points,
    normals: Float32Array.from(unpack(model.normals, Int16Array), (n) => n / 32767),
    triangles: unpack(model.triangles, Uint16Array),
    faces: unpack(model.faces, Uint16Array),
    hasDeviation: Boolean(model.deviation),
    deviation: model.deviation ? unpackRange(model.deviation) : zeros(),
    angle: model.angle ? unpackRange(model.angle) : zeros(),
    curvature: unpackRange(model.curvature),
    lines: unpackLines(model.lines),
  };
}

/** Ends of segments between points that follow each other on one line. */
function unpackLines(lines) {
  const segments = [];
  let begin = 0;
  for (const end of lines.ends) {
    for (let i = begin; i + 1 < end; ++i) segments.push(i, i + 1);
    begin = end;
  }
  return { points: unpackPoints(lines.points), segments: new Uint32Array(segments) };
}

const vertexShader = `
attribute vec3 faceColour;
attribute float deviation, angle, curvature;
varying vec3 vNormal, vPosition, vFaceColour;
varying float vDeviation, vAngle, vCurvature;
void main() {
  vec4 place = modelViewMatrix * vec4(position, 1.0);
  vPosition = place.xyz;
  vNormal = normalMatrix * normal;
  vFaceColour = faceColour;
  vDeviation = deviation;
  vAngle = angle;
  vCurvature = curvature;
  gl_Position = projectionMatrix * place;
}`;

// Zebra: the reflection of long lamps all around, as on a car's body in a light tunnel.
const fragmentShader = `
uniform int layer;
uniform float deviationScale, angleScale, curvatureScale;
uniform vec3 stops[5];
varying vec3 vNormal, vPosition, vFaceColour;
varying float vDeviation, vAngle, vCurvature;
vec3 ramp(float t) {
  float s = clamp(t, 0.0, 1.0) * 4.0;
  vec3 c = mix(stops[0], stops[1], clamp(s, 0.0, 1.0));
  c = mix(c, stops[2], clamp(s - 1.0, 0.0, 1.0));
  c = mix(c, stops[3], clamp(s - 2.0, 0.0, 1.0));
  return mix(c, stops[4], clamp(s - 3.0, 0.0, 1.0));
}
vec3 diverging(float t) {
  float s = clamp(t, -1.0, 1.0);
  return s < 0.0 ? mix(vec3(0.93), stops[0], -s) : mix(vec3(0.93), stops[4], s);
}
float stripes(vec3 n, vec3 eye) {
  vec3 r = reflect(-eye, n);
  float place = 14.0 * acos(clamp(r.y, -1.0, 1.0)) / 3.14159265;
  float blur = max(fwidth(place), 1e-4);
  return smoothstep(0.25 - blur, 0.25 + blur, abs(fract(place) - 0.5));
}
void main() {
  vec3 eye = normalize(-vPosition);
  vec3 n = normalize(vNormal);
  if (dot(n, eye) < 0.0) n = -n;
  vec3 colour = vec3(0.74, 0.76, 0.79);
  if (layer == 1) colour = ramp(vDeviation / deviationScale);
  else if (layer == 2) colour = ramp(vAngle / angleScale);
  else if (layer == 3) colour = diverging(vCurvature / curvatureScale);
  else if (layer == 4) colour = vFaceColour;
  else if (layer == 5) colour = vec3(0.06 + 0.9 * stripes(n, eye));
  float light = layer == 5 ? 1.0 : 0.4 + 0.6 * dot(n, eye);
  gl_FragColor = vec4(colour * light, 1.0);
}`;

/** One material for all models, so that a layer is chosen for all. */
export function makeMaterial(data) {
  return new ShaderMaterial({
    vertexShader, fragmentShader, side: DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 2,
    uniforms: {
      layer: { value: 0 },
      deviationScale: { value: data.scale },
      angleScale: { value: 1 },
      curvatureScale: { value: data.models[0].curvature.high },
      stops: { value: data.colours.map(([r, g, b]) => new Color().setRGB(r, g, b, "srgb-linear")) },
    },
  });
}

export function makeMesh(model, material) {
  const geometry = new BufferGeometry();
  const attributes = { position: [model.points, 3], normal: [model.normals, 3], faceColour: [faceColours(model.faces), 3],
    deviation: [model.deviation, 1], angle: [model.angle, 1], curvature: [model.curvature, 1] };
  for (const [name, [values, size]] of Object.entries(attributes)) geometry.setAttribute(name, new BufferAttribute(values, size));
  geometry.setIndex(new BufferAttribute(model.triangles, 1));
  return new Mesh(geometry, material);
}

export function makeSegments(points, indices, colour) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(points, 3));
  geometry.setIndex(new BufferAttribute(indices, 1));
  return new LineSegments(geometry, new LineBasicMaterial({ color: colour }));
}

export function unpackCage(cage) {
  return { points: unpackPoints(cage.points), edges: unpack(cage.edges, Uint16Array),
    extraordinary: unpackPoints(cage.extraordinary) };
}
