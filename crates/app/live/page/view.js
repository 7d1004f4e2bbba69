// Draws a moment of the scene with WebGL2.

import { add, axesAt, clamp, cross, dot, fromX, lookAt, matMul, mix, norm, ortho, perspective, quatMul, rotate, scale, sub, unit } from "./math.js";
import { cone, roundBox } from "./mesh.js";

const FILES = ["./light.glsl", "./solid.vert.glsl", "./solid.frag.glsl", "./ground.vert.glsl", "./ground.frag.glsl", "./net.vert.glsl", "./net.frag.glsl", "./sky.vert.glsl", "./sky.frag.glsl"];
const FIELD = 0.66;
const INSTANCE = 15;
const SHADOW = 2048;
const REACH = 6.5;
// Length of a force's arrow [m/N].
const FORCE = 1 / 1000;
export const NET_DEPTH = 0.75;

const LOOKS = {
  bright: {
    sun: [0.45, -0.5, 0.95], sunColor: [1.75, 1.66, 1.5], sky: [0.5, 0.58, 0.7], bounce: [0.2, 0.25, 0.17],
    haze: [0.56, 0.72, 0.9], grass: [0.06, 0.165, 0.035], line: [0.82, 0.85, 0.82], top: [0.09, 0.27, 0.62],
  },
  dark: {
    sun: [0.4, -0.55, 0.9], sunColor: [1.25, 1.3, 1.45], sky: [0.16, 0.2, 0.3], bounce: [0.05, 0.08, 0.06],
    haze: [0.012, 0.02, 0.034], grass: [0.04, 0.115, 0.045], line: [0.62, 0.68, 0.72], top: [0.002, 0.003, 0.008],
  },
};
const COLORS = { shell: [0.62, 0.65, 0.7], sole: [0.05, 0.055, 0.065], bone: [0.07, 0.075, 0.09], head: [0.62, 0.65, 0.7] };
const ROUND = [1, 0, 0, 0];
// Nearest thing in the robot's image: the front of its head is behind that [m].
const OWN_NEAR = 0.12;
// A ball that was last seen this long ago counts as remembered [s].
export const REMEMBERED = 0.2;
const SEEN = [0.1, 0.75, 1];
const KEPT = [1, 0.5, 0.08];

export class View {
  static async create(canvas) {
    const texts = await Promise.all(FILES.map(async (file) => (await fetch(file)).text()));
    return new View(canvas, texts);
  }

  constructor(canvas, texts) {
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: false, powerPreference: "high-performance" });
    if (!gl) throw new Error("This browser has no WebGL2, which the page needs.");
    this.canvas = canvas;
    this.gl = gl;
    const [light, solidV, solidF, groundV, groundF, netV, netF, skyV, skyF] = texts;
    this.solid = this.program(solidV, light + solidF);
    this.ground = this.program(groundV, light + groundF);
    this.net = this.program(netV, light + netF);
    this.sky = this.program(skyV, light + skyF);
    this.caster = this.program(solidV, "void main() {}\n");
    this.coarse = this.mesh(roundBox(5));
    this.fine = this.mesh(roundBox(12));
    this.tip = this.mesh(cone(20));
    this.quad = this.flat(new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1]), [2]);
    this.shadow = this.makeShadow();
    this.heat = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.heat);
    for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, gl.NEAREST], [gl.TEXTURE_MAG_FILTER, gl.NEAREST], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]])
      gl.texParameteri(gl.TEXTURE_2D, name, value);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    this.scene = null;
    this.detail = 1;
    this.camera = { azimuth: -2.5, elevation: 0.32, distance: 5.4, target: [1.3, 0, 0.55] };
    this.dark = false;
    this.resize();
    // A tall window sees the goal only from behind the robot.
    if (this.aspect < 1) Object.assign(this.camera, { azimuth: -2.86, distance: 6.2 });
  }

  program(vertex, fragment) {
    const { gl } = this;
    const head = "#version 300 es\nprecision highp float;\nprecision highp int;\n";
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, head + text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) throw new Error(gl.getProgramInfoLog(program));
    const places = {};
    const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS);
    for (let i = 0; i < count; i++) {
      const { name } = gl.getActiveUniform(program, i);
      places[name] = gl.getUniformLocation(program, name);
    }
    return { program, places };
  }

  mesh({ vertices, indices }) {
    const { gl } = this;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, vertices, gl.STATIC_DRAW);
    for (let k = 0; k < 3; k++) {
      gl.enableVertexAttribArray(k);
      gl.vertexAttribPointer(k, 3, gl.FLOAT, false, 36, 12 * k);
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
    const instances = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, instances);
    let at = 0;
    for (const [k, size] of [[3, 4], [4, 3], [5, 4], [6, 4]]) {
      gl.enableVertexAttribArray(k);
      gl.vertexAttribPointer(k, size, gl.FLOAT, false, 4 * INSTANCE, 4 * at);
      gl.vertexAttribDivisor(k, 1);
      at += size;
    }
    gl.bindVertexArray(null);
    return { array, instances, count: indices.length };
  }

  flat(data, sizes) {
    const { gl } = this;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    const stride = sizes.reduce((a, b) => a + b);
    let at = 0;
    sizes.forEach((size, k) => {
      gl.enableVertexAttribArray(k);
      gl.vertexAttribPointer(k, size, gl.FLOAT, false, 4 * stride, 4 * at);
      at += size;
    });
    gl.bindVertexArray(null);
    return { array, count: data.length / stride };
  }

  makeShadow() {
    const { gl } = this;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.DEPTH_COMPONENT24, SHADOW, SHADOW, 0, gl.DEPTH_COMPONENT, gl.UNSIGNED_INT, null);
    for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_MAG_FILTER, gl.LINEAR], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE], [gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE], [gl.TEXTURE_COMPARE_FUNC, gl.LEQUAL]])
      gl.texParameteri(gl.TEXTURE_2D, name, value);
    const frame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, texture, 0);
    gl.drawBuffers([gl.NONE]);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return { texture, frame };
  }

  setScene(scene) {
    this.scene = scene;
    const [h, w, d] = [scene.goal_height_m, scene.goal_half_width_m, NET_DEPTH];
    // A net of four sides: back, top, left, right. The back leans.
    const top = 0.35 * d;
    const slope = Math.hypot(h, d - top);
    const side = (y) => [
      [0, y, 0, 0, 0], [d, y, 0, d, 0], [0, y, h, 0, h],
      [d, y, 0, d, 0], [top, y, h, top, h], [0, y, h, 0, h],
    ];
    const rows = [
      [d, -w, 0, -w, 0], [d, w, 0, w, 0], [top, -w, h, -w, slope], [d, w, 0, w, 0], [top, w, h, w, slope], [top, -w, h, -w, slope],
      [0, -w, h, -w, 0], [0, w, h, w, 0], [top, -w, h, -w, top], [0, w, h, w, 0], [top, w, h, w, top], [top, -w, h, -w, top],
      ...side(-w), ...side(w),
    ];
    this.netMesh = this.flat(new Float32Array(rows.flat()), [3, 2]);
    this.posts = this.goalParts(w, h, d, top);
  }

  // Frame of the goal in its own axes.
  goalParts(w, h, d, top) {
    const white = [0.9, 0.9, 0.9, 0];
    const thin = [0.5, 0.52, 0.55, 0];
    const bar = (a, b, radius, color) => {
      const along = sub(b, a);
      return { quat: fromX(along), center: scale(add(a, b), 0.5), half: [norm(along) / 2 + radius, radius, radius, radius], color };
    };
    const parts = [bar([0, -w, h], [0, w, h], 0.035, white), bar([d, -w, 0.015], [d, w, 0.015], 0.015, thin)];
    for (const y of [-w, w])
      parts.push(bar([0, y, 0], [0, y, h], 0.035, white), bar([d, y, 0.015], [top, y, h], 0.014, thin), bar([0, y, 0.015], [d, y, 0.015], 0.014, thin), bar([0, y, h], [top, y, h], 0.014, thin));
    return parts;
  }

  resize() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2) * this.detail;
    const [w, h] = [Math.max(1, Math.round(this.canvas.clientWidth * ratio)), Math.max(1, Math.round(this.canvas.clientHeight * ratio))];
    if (this.canvas.width !== w || this.canvas.height !== h) {
      this.canvas.width = w;
      this.canvas.height = h;
    }
    this.aspect = w / h;
  }

  // Where the camera is, and what a pixel sees.
  look() {
    const { azimuth, elevation, distance, target } = this.camera;
    const c = Math.cos(elevation);
    const eye = add(target, scale([c * Math.cos(azimuth), c * Math.sin(azimuth), Math.sin(elevation)], distance));
    eye[2] = Math.max(eye[2], 0.12);
    // A narrow window shows as much from side to side as a wide one shows from top to bottom.
    const field = this.aspect < 1 ? 2 * Math.atan(Math.tan(FIELD / 2) / Math.max(this.aspect, 0.62)) : FIELD;
    this.eye = eye;
    this.back = unit(sub(eye, target));
    this.right = unit(cross([0, 0, 1], this.back));
    this.up = cross(this.back, this.right);
    this.tan = Math.tan(field / 2);
    this.clip = matMul(perspective(field, this.aspect, 0.05, 160), lookAt(eye, target));
  }

  // The direction in which a point of the canvas looks.
  ray(x, y) {
    const [u, v] = [(2 * x) / this.canvas.clientWidth - 1, 1 - (2 * y) / this.canvas.clientHeight];
    return unit(add(add(scale(this.right, u * this.tan * this.aspect), scale(this.up, v * this.tan)), scale(this.back, -1)));
  }

  // The point at a height that a point of the canvas shows; null above the horizon.
  onPlane(x, y, height) {
    const d = this.ray(x, y);
    if (d[2] > -0.01) return null;
    const t = (height - this.eye[2]) / d[2];
    return t > 0 && t < 60 ? add(this.eye, scale(d, t)) : null;
  }

  // The point of the canvas that shows a point; null behind the camera.
  project(p) {
    const m = this.clip;
    const w = m[3] * p[0] + m[7] * p[1] + m[11] * p[2] + m[15];
    if (w <= 0) return null;
    const [x, y] = [m[0] * p[0] + m[4] * p[1] + m[8] * p[2] + m[12], m[1] * p[0] + m[5] * p[1] + m[9] * p[2] + m[13]];
    return [((x / w + 1) / 2) * this.canvas.clientWidth, ((1 - y / w) / 2) * this.canvas.clientHeight];
  }

  setHeat(cells, [rows, columns]) {
    const { gl } = this;
    const data = new Uint8Array(4 * cells.length);
    cells.forEach(({ shots, goals }, i) => {
      if (!shots) return;
      const share = goals / shots;
      data.set([mix(230, 30, share), mix(70, 190, share), mix(40, 90, share), 150 + 60 * Math.min(1, shots / 3)], 4 * i);
    });
    gl.bindTexture(gl.TEXTURE_2D, this.heat);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, columns, rows, 0, gl.RGBA, gl.UNSIGNED_BYTE, data);
  }

  draw(moment, show) {
    const { gl, scene } = this;
    this.resize();
    this.look();
    const look = this.dark ? LOOKS.dark : LOOKS.bright;
    const sun = unit(look.sun);
    const fine = [];
    const coarse = [];
    const tips = [];
    const put = (list, quat, pos, half, color) => list.push(...quat, ...pos, ...half, ...color);
    const robot = (bodies, list, color) => {
      for (const part of scene.parts) {
        const body = bodies[part.body];
        if (!body) continue;
        const tint = color || [...COLORS[part.look], part.look === "head" ? 2 : part.look === "shell" ? 0 : 4];
        put(list, quatMul(body.quat, part.quat), add(body.pos, rotate(body.quat, part.center)), [...part.half, part.round], tint);
      }
    };
    robot(moment.bodies, coarse);
    const [gx, gy, heading] = moment.goal;
    const turn = [Math.cos(heading / 2), 0, 0, Math.sin(heading / 2)];
    for (const part of scene.ball ? this.posts : []) put(coarse, quatMul(turn, part.quat), add([gx, gy, 0], rotate(turn, part.center)), part.half, part.color);
    const r = scene.ball_radius_m;
    if (scene.ball) put(fine, moment.ball.quat, moment.ball.pos, [r, r, r, r], [1, 1, 1, 1]);

    // Shadows of everything solid.
    const middle = [moment.bodies[0].pos[0] + 2.2 * Math.cos(heading), moment.bodies[0].pos[1] + 2.2 * Math.sin(heading), 0];
    const from = matMul(ortho(REACH, 1, 30), lookAt(add(middle, scale(sun, 15)), middle));
    this.upload(this.coarse, coarse);
    this.upload(this.fine, fine);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadow.frame);
    gl.viewport(0, 0, SHADOW, SHADOW);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    gl.depthFunc(gl.LESS);
    gl.disable(gl.BLEND);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.useProgram(this.caster.program);
    gl.uniformMatrix4fv(this.caster.places.uClip, false, from);
    this.instances(this.coarse);
    this.instances(this.fine);

    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.shadow.texture);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, this.heat);
    const light = { look, sun, from, moment, show };
    this.solids(this, [0, 0, this.canvas.width, this.canvas.height], light);
    const solid = this.solid.places;

    // What shines: trail, forces, the push.
    const shining = [];
    const arrow = (at, vector, radius, color) => {
      const length = norm(vector);
      if (length < 0.03) return;
      const d = unit(vector);
      const head = Math.min(radius * 5, length * 0.5);
      const shaft = length - head;
      put(shining, fromX(d), add(at, scale(d, shaft / 2)), [shaft / 2, radius, radius, radius * 0.99], [...color, 3]);
      put(tips, fromX(d), add(at, scale(d, shaft)), [head / 2, head / 2, head / 2, head / 2], [...color, 3]);
    };
    for (const [i, p] of show.trail.entries()) {
      const size = 0.012 + 0.02 * (i / show.trail.length);
      put(shining, ROUND, p, [size, size, size, size], [1, 0.55, 0.12, 3]);
    }
    if (show.forces)
      for (const force of moment.forces) {
        const at = force.body === 255 ? moment.ball.pos : moment.bodies[force.body] && moment.bodies[force.body].pos;
        if (at) arrow(at, scale(force.newton, FORCE), 0.014, [1, 0.16, 0.2]);
      }
    if (show.push) arrow(show.push.from, show.push.vector, 0.03, [1, 0.78, 0.1]);
    const belief = show.belief && scene.camera && moment.belief;
    const fresh = belief && belief.age < REMEMBERED ? SEEN : KEPT;
    if (belief) {
      const way = (points, color) =>
        points.forEach((from, i) => {
          const along = sub(points[(i + 1) % points.length], from);
          put(shining, fromX(along), add(from, scale(along, 0.5)), [norm(along) / 2, 0.008, 0.008, 0.0079], [...color, 3]);
        });
      way(this.footprint(moment), moment.inView ? SEEN : KEPT);
      const [x, y] = belief.pos;
      const spread = Math.max(2 * belief.deviation, 0.01);
      const around = (k) => [x + spread * Math.cos((k * Math.PI) / 12), y + spread * Math.sin((k * Math.PI) / 12), 0.008];
      way([...Array(24).keys()].map(around), fresh);
    }
    this.upload(this.coarse, shining);
    this.instances(this.coarse);
    this.upload(this.tip, tips);
    this.instances(this.tip);

    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE);
    const glass = (mesh, list) => {
      this.upload(mesh, list);
      // Depth first, so that only what is in front is seen through.
      gl.colorMask(false, false, false, false);
      this.instances(mesh);
      gl.colorMask(true, true, true, true);
      gl.depthFunc(gl.LEQUAL);
      gl.uniform1f(solid.uAlpha, 0.42);
      this.instances(mesh);
      gl.depthFunc(gl.LESS);
    };
    if (show.ghost && moment.ghost.length) {
      const ghost = [];
      robot(moment.ghost, ghost, [0.12, 0.4, 1, 4]);
      glass(this.coarse, ghost);
    }
    if (belief) {
      const ball = [];
      const r = 1.06 * scene.ball_radius_m;
      put(ball, ROUND, belief.pos, [r, r, r, r], [...fresh, 4]);
      glass(this.fine, ball);
    }
    this.netting(this, light);
    this.picture = show.picture && scene.camera ? this.ownPicture(moment, show.picture) : null;
    if (this.picture) {
      const [x, y, w, h] = this.picture.area;
      gl.enable(gl.SCISSOR_TEST);
      gl.scissor(x, y, w, h);
      this.upload(this.coarse, coarse);
      this.upload(this.fine, fine);
      this.solids(this.picture, this.picture.area, light);
      this.netting(this.picture, light);
      gl.disable(gl.SCISSOR_TEST);
    }
    gl.bindVertexArray(null);
  }

  // What all programs know: from where it is seen, and in which light.
  common({ program, places }, point, { look, sun, from }) {
    const { gl } = this;
    gl.useProgram(program);
    if (places.uClip) gl.uniformMatrix4fv(places.uClip, false, point.clip);
    for (const [name, value] of [["uEye", point.eye], ["uSun", sun], ["uSunColor", look.sunColor], ["uSkyColor", look.sky], ["uBounce", look.bounce], ["uHaze", look.haze]])
      if (places[name]) gl.uniform3fv(places[name], value);
    if (places.uShadow) gl.uniform1i(places.uShadow, 0);
    if (places.uShadowFrom) gl.uniformMatrix4fv(places.uShadowFrom, false, from);
    return places;
  }

  // Sky, ground and everything solid, as seen from a point, into an area of the canvas.
  solids(point, area, light) {
    const { gl, scene } = this;
    const { look, moment, show } = light;
    const [gx, gy, heading] = moment.goal;
    gl.viewport(...area);
    const haze = look.haze.map((x) => clamp((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14), 0, 1) ** (1 / 2.2));
    gl.clearColor(...haze, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);

    const sky = this.common(this.sky, point, light);
    gl.depthMask(false);
    gl.uniformMatrix3fv(sky.uView, false, [...point.right, ...point.up, ...point.back]);
    gl.uniform2f(sky.uField, point.tan * point.aspect, point.tan);
    gl.uniform3fv(sky.uTop, look.top);
    gl.bindVertexArray(this.quad.array);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    gl.depthMask(true);

    const ground = this.common(this.ground, point, light);
    gl.uniform2f(ground.uMiddle, this.camera.target[0], this.camera.target[1]);
    gl.uniform3fv(ground.uGrass, look.grass);
    gl.uniform3fv(ground.uLine, look.line);
    gl.uniform3f(ground.uGoal, gx, gy, heading);
    gl.uniform1f(ground.uHalfMouth, scene.goal_half_width_m);
    gl.uniform4f(ground.uRobot, ...show.stance, show.reach);
    const half = scene.grid.step / 2;
    gl.uniform4f(ground.uReach, scene.grid.x[0] - half, scene.grid.x[1] + half, scene.grid.y[0] - half, scene.grid.y[1] + half);
    gl.uniform1i(ground.uHeat, 1);
    gl.uniform2f(ground.uCells, scene.cells[1], scene.cells[0]);
    gl.uniform1f(ground.uHeatShare, point === this ? show.heat : 0);
    gl.bindVertexArray(this.quad.array);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);

    gl.uniform1f(this.common(this.solid, point, light).uAlpha, 1);
    this.instances(this.coarse);
    this.instances(this.fine);
  }

  netting(point, light) {
    const { gl } = this;
    if (!this.scene.ball) return;
    const net = this.common(this.net, point, light);
    gl.uniform3f(net.uGoal, ...light.moment.goal);
    gl.uniform3fv(net.uThread, this.dark ? [0.55, 0.6, 0.65] : [0.8, 0.82, 0.84]);
    gl.enable(gl.BLEND);
    gl.depthMask(false);
    gl.bindVertexArray(this.netMesh.array);
    gl.drawArrays(gl.TRIANGLES, 0, this.netMesh.count);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
  }

  // The point from which the robot's camera sees, and where on the canvas its image is drawn: into an element of the page.
  ownPicture(moment, element) {
    const { body, mount, corners } = this.scene.camera;
    const carrier = moment.bodies[body];
    const turned = corners.map((ray) => rotate(carrier.quat, ray));
    const [leftTop, rightTop, , leftBottom] = turned;
    const ahead = scale(turned.reduce(add), 1 / 4);
    const [across, upright] = [scale(sub(rightTop, leftTop), 0.5), scale(sub(leftTop, leftBottom), 0.5)];
    const eye = add(carrier.pos, rotate(carrier.quat, mount));
    const [right, up, back] = [unit(across), unit(upright), unit(scale(ahead, -1))];
    const tan = norm(upright) / norm(ahead);
    const aspect = norm(across) / norm(upright);
    const clip = matMul(perspective(2 * Math.atan(tan), aspect, OWN_NEAR, 160), axesAt(eye, right, up, back));
    const [box, canvas] = [element.getBoundingClientRect(), this.canvas.getBoundingClientRect()];
    const dots = this.canvas.width / canvas.width;
    const area = [(box.left - canvas.left) * dots, (canvas.bottom - box.bottom) * dots, box.width * dots, box.height * dots].map(Math.round);
    return { eye, right, up, back, tan, aspect, clip, area };
  }

  // Where the robot's image shows a ball: center and half its size as shares of width and height; null outside the image.
  inPicture(place) {
    const { eye, right, up, back, tan, aspect } = this.picture;
    const to = sub(place, eye);
    const depth = -dot(to, back);
    if (depth < OWN_NEAR) return null;
    const [x, y] = [dot(to, right) / (depth * tan * aspect), dot(to, up) / (depth * tan)];
    const size = this.scene.ball_radius_m / (depth * tan);
    if (Math.abs(x) > 1 + size / aspect || Math.abs(y) > 1 + size) return null;
    return { x: (1 + x) / 2, y: (1 - y) / 2, half: [size / aspect / 2, size / 2] };
  }

  // The outline of the ground in the robot's image; toward the horizon, as far as it detects a ball.
  footprint(moment) {
    const { body, mount, corners, far_m } = this.scene.camera;
    const carrier = moment.bodies[body];
    const eye = add(carrier.pos, rotate(carrier.quat, mount));
    return corners.flatMap((from, i) =>
      [...Array(6).keys()].map((k) => {
        const to = corners[(i + 1) % corners.length];
        const ray = unit(rotate(carrier.quat, add(from, scale(sub(to, from), k / 6))));
        const reach = ray[2] < -0.001 ? Math.min(-eye[2] / ray[2], far_m) : far_m;
        const [x, y] = add(eye, scale(ray, reach));
        return [x, y, 0.008];
      }),
    );
  }

  upload(mesh, list) {
    const { gl } = this;
    mesh.shown = list.length / INSTANCE;
    gl.bindBuffer(gl.ARRAY_BUFFER, mesh.instances);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(list), gl.DYNAMIC_DRAW);
  }

  instances(mesh) {
    const { gl } = this;
    if (!mesh.shown) return;
    gl.bindVertexArray(mesh.array);
    gl.drawElementsInstanced(gl.TRIANGLES, mesh.count, gl.UNSIGNED_SHORT, 0, mesh.shown);
  }

  // What lies under a point of the canvas: the ball, the robot or the goal, the nearer first; fingers are thicker than arrows.
  pick(moment, x, y, slack) {
    const direction = this.ray(x, y);
    const size = (p) => (slack * this.tan * 2 * norm(sub(p, this.eye))) / this.canvas.clientHeight;
    const distance = (p) => {
      const to = sub(p, this.eye);
      return norm(sub(to, scale(direction, dot(to, direction))));
    };
    const ball = moment.ball.pos;
    if (this.scene.ball && distance(ball) < this.scene.ball_radius_m + size(ball)) return { what: "ball" };
    let best = null;
    for (const part of this.scene.parts) {
      const body = moment.bodies[part.body];
      const at = add(body.pos, rotate(body.quat, part.center));
      const off = distance(at) - Math.max(part.half[1], 0.4 * part.half[0]) - 0.5 * size(at);
      if (off < 0 && (!best || off < best.off)) best = { what: "robot", at, off };
    }
    if (best) return best;
    const [gx, gy, heading] = moment.goal;
    const [c, s] = [Math.cos(heading), Math.sin(heading)];
    for (const part of this.scene.ball ? this.posts : []) {
      const along = rotate(part.quat, [1, 0, 0]);
      for (let k = -1; k <= 1; k += 0.1) {
        const p = add(part.center, scale(along, k * part.half[0]));
        const world = [gx + c * p[0] - s * p[1], gy + s * p[0] + c * p[1], p[2]];
        if (distance(world) < 0.05 + size(world)) return { what: "goal" };
      }
    }
    return { what: "ground" };
  }
}
