// Mouse, fingers and keys: what they hold, and what that means.

import { add, clamp, norm, scale, sub } from "./math.js";
import { command } from "./wire.js";

// Impulse of a push per meter of its arrow [N s/m], and the hardest: the program takes 120, which rounding must not exceed [N s].
const PUSH = 60;
const HARDEST = 119.999;
// A ball that was held still for this long is put down, not flicked [ms].
const STILL = 90;
const FASTEST = 7;
// The ball stays on the pitch [m].
const FARTHEST = 14;

const within = (p) => {
  const far = Math.hypot(p[0], p[1]);
  return far > FARTHEST ? [(p[0] * FARTHEST) / far, (p[1] * FARTHEST) / far] : [p[0], p[1]];
};

export class Hand {
  constructor(canvas, view, send, state) {
    Object.assign(this, { canvas, view, send, state });
    this.pointers = new Map();
    this.holds = null;
    this.ball = null;
    this.push = null;
    this.follow = true;
    canvas.addEventListener("pointerdown", (e) => this.down(e));
    canvas.addEventListener("pointermove", (e) => this.move(e));
    for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, (e) => this.up(e));
    canvas.addEventListener("wheel", (e) => this.wheel(e), { passive: false });
    canvas.addEventListener("contextmenu", (e) => e.preventDefault());
    // A hand that rests says that it still holds the ball.
    setInterval(() => this.repeat(), 300);
  }

  // What is under a pointer. A page that only watches, or shows clips, can take nothing.
  under(moment, x, y, slack) {
    return this.view.scene.watched || this.view.scene.kicks ? { what: "ground" } : this.view.pick(moment, x, y, slack);
  }

  at(e) {
    const box = this.canvas.getBoundingClientRect();
    return [e.clientX - box.left, e.clientY - box.top];
  }

  down(e) {
    this.canvas.focus();
    const [x, y] = this.at(e);
    this.canvas.setPointerCapture(e.pointerId);
    this.pointers.set(e.pointerId, { x, y });
    const moment = this.state.moment;
    if (this.pointers.size > 1 || !moment) {
      this.letGo(false);
      this.holds = { what: "camera" };
      return;
    }
    const { replaying } = this.state;
    this.state.stopReplay();
    const slack = e.pointerType === "touch" ? 26 : 10;
    const turned = e.button === 2 || e.button === 1 || e.ctrlKey;
    // What a replay shows is not there now.
    const hit = turned ? { what: "pan" } : replaying ? { what: "ground" } : this.under(moment, x, y, slack);
    this.holds = hit;
    if (hit.what === "ball") {
      this.ball = { at: [moment.ball.pos[0], moment.ball.pos[1]], way: [], grip: null };
      const p = this.view.onPlane(x, y, this.view.scene.ball_radius_m);
      if (p) this.ball.grip = [moment.ball.pos[0] - p[0], moment.ball.pos[1] - p[1]];
      this.moveBall(x, y, e.timeStamp);
    } else if (hit.what === "robot") {
      this.push = { from: hit.at, vector: [0, 0, 0] };
    } else if (hit.what === "goal") {
      const p = this.view.onPlane(x, y, 0);
      hit.grip = p ? [moment.goal[0] - p[0], moment.goal[1] - p[1]] : [0, 0];
    }
    this.cursor();
  }

  move(e) {
    const [x, y] = this.at(e);
    const last = this.pointers.get(e.pointerId);
    if (!last) {
      if (this.state.moment && !this.state.replaying) this.hover = this.under(this.state.moment, x, y, 10).what;
      this.cursor();
      return;
    }
    const [dx, dy] = [x - last.x, y - last.y];
    if (this.pointers.size >= 2) {
      this.pinch(e.pointerId, x, y);
      Object.assign(last, { x, y });
      return;
    }
    Object.assign(last, { x, y });
    const what = this.holds && this.holds.what;
    if (what === "ball") this.moveBall(x, y, e.timeStamp);
    else if (what === "goal") {
      const p = this.view.onPlane(x, y, 0);
      if (p) this.send(command.goal(within([p[0] + this.holds.grip[0], p[1] + this.holds.grip[1]])));
    } else if (what === "robot") {
      const p = this.view.onPlane(x, y, this.push.from[2]) || this.view.onPlane(x, y, 0);
      if (p) {
        const vector = [p[0] - this.push.from[0], p[1] - this.push.from[1], 0];
        this.push.vector = scale(vector, Math.min(1, HARDEST / (PUSH * (norm(vector) || 1))));
      }
    } else if (what === "pan") this.pan(dx, dy);
    else if (what === "ground") this.orbit(-dx * 0.006, dy * 0.006);
  }

  up(e) {
    if (!this.pointers.delete(e.pointerId)) return;
    if (this.pointers.size > 0) return;
    this.letGo(e.type === "pointerup", e.timeStamp);
    this.holds = null;
    this.cursor();
  }

  // What is held is let go; `done` is false if the hand does something else now.
  letGo(done, time = 0) {
    if (this.ball) {
      const { at, way } = this.ball;
      const recent = way.filter((w) => time - w.time < 120);
      let velocity = [0, 0];
      if (done && recent.length > 1 && time - recent[recent.length - 1].time < STILL) {
        const [a, b] = [recent[0], recent[recent.length - 1]];
        const seconds = (b.time - a.time) / 1000;
        if (seconds > 0.01) velocity = [(b.at[0] - a.at[0]) / seconds, (b.at[1] - a.at[1]) / seconds];
      }
      const speed = Math.hypot(...velocity);
      if (speed > FASTEST) velocity = velocity.map((v) => (v * FASTEST) / speed);
      this.send(command.drop(at, velocity));
    } else if (this.push && done) {
      const impulse = this.impulse();
      if (norm(impulse) > 1) this.send(command.push([impulse[0], impulse[1]]));
    }
    this.ball = null;
    this.push = null;
  }

  impulse() {
    return this.push ? scale(this.push.vector, PUSH) : [0, 0, 0];
  }

  moveBall(x, y, time) {
    const p = this.view.onPlane(x, y, this.view.scene.ball_radius_m);
    if (!p) return;
    const grip = this.ball.grip || [0, 0];
    this.ball.at = within([p[0] + grip[0], p[1] + grip[1]]);
    this.ball.way.push({ at: this.ball.at, time });
    if (this.ball.way.length > 40) this.ball.way.shift();
    this.ball.moved = true;
  }

  // Once per drawing.
  flush() {
    if (this.ball && this.ball.moved) {
      this.ball.moved = false;
      this.send(command.hold(this.ball.at));
    }
  }

  repeat() {
    if (this.ball) this.send(command.hold(this.ball.at));
  }

  orbit(turn, raise) {
    const { camera } = this.view;
    camera.azimuth += turn;
    camera.elevation = clamp(camera.elevation + raise, 0.02, 1.5);
  }

  pan(dx, dy) {
    const { view } = this;
    const size = (2 * view.tan * view.camera.distance) / this.canvas.clientHeight;
    const ahead = [-view.back[0], -view.back[1], 0];
    const length = norm(ahead) || 1;
    const move = add(scale(view.right, -dx * size), scale(ahead, (dy * size) / length));
    view.camera.target = add(view.camera.target, [move[0], move[1], 0]);
    this.follow = false;
  }

  zoom(factor) {
    const { camera } = this.view;
    camera.distance = clamp(camera.distance * factor, 1.2, 22);
  }

  wheel(e) {
    e.preventDefault();
    this.zoom(Math.exp(clamp(e.deltaY * (e.deltaMode ? 30 : 1), -200, 200) * 0.0012));
  }

  // Two fingers: their distance zooms, their middle moves the view.
  pinch(id, x, y) {
    const points = [...this.pointers].slice(0, 2);
    const index = points.findIndex(([key]) => key === id);
    if (index < 0) return;
    const [a, b] = [points[index][1], points[1 - index][1]];
    const [before, after] = [Math.hypot(a.x - b.x, a.y - b.y), Math.hypot(x - b.x, y - b.y)];
    if (after > 1) this.zoom(clamp(before / after, 0.8, 1.25));
    this.pan((x - a.x) / 2, (y - a.y) / 2);
  }

  cursor() {
    const held = this.holds && this.holds.what;
    const what = held || this.hover;
    const grabs = what === "ball" || what === "goal" || what === "robot";
    this.canvas.style.cursor = held ? "grabbing" : grabs ? "grab" : "default";
  }

  // Keeps the robot, and a little of what is ahead of it, in the middle.
  track(moment, passed) {
    if (!this.follow || this.holds) return;
    const base = moment.bodies[0].pos;
    const heading = Math.atan2(moment.goal[1] - base[1], moment.goal[0] - base[0]);
    const ahead = this.view.scene.ball ? 1.2 : 0;
    const wanted = [base[0] + ahead * Math.cos(heading), base[1] + ahead * Math.sin(heading), 0.55];
    const share = 1 - Math.exp(-passed * 2.2);
    const { camera } = this.view;
    camera.target = add(camera.target, scale(sub(wanted, camera.target), share));
  }
}
