// The course of the scene: frames arrive 50 times a second, from a robot on the network 10 times, and are drawn when the display is ready. Shows a
// moment a little in the past, between two frames, and keeps enough to show the last shot again.

import { mix } from "./math.js";

const KEPT = 900;
// How far the drawing is behind the newest frame, at least [s], and where frames are farther apart, as a multiple of their distance.
const BEHIND = 0.045;
const APART = 1.4;

function between(a, b, t) {
  const pos = [0, 1, 2].map((k) => mix(a.pos[k], b.pos[k], t));
  const d = a.quat[0] * b.quat[0] + a.quat[1] * b.quat[1] + a.quat[2] * b.quat[2] + a.quat[3] * b.quat[3];
  const s = d < 0 ? -1 : 1;
  const quat = [0, 1, 2, 3].map((k) => mix(a.quat[k], s * b.quat[k], t));
  const n = Math.hypot(...quat) || 1;
  return { pos, quat: quat.map((x) => x / n) };
}

// A robot that was put elsewhere does not fly there.
const jumped = (a, b) => Math.hypot(a.pos[0] - b.pos[0], a.pos[1] - b.pos[1]) > 0.25;

function blend(a, b, t) {
  if (t <= 0 || a === b || a.bodies.length !== b.bodies.length) return a;
  if (jumped(a.bodies[0], b.bodies[0])) return t < 0.5 ? a : b;
  return {
    ...b,
    time: mix(a.time, b.time, t),
    ball: jumped(a.ball, b.ball) ? b.ball : between(a.ball, b.ball, t),
    bodies: a.bodies.map((body, i) => between(body, b.bodies[i], t)),
    ghost: a.ghost.length === b.ghost.length ? a.ghost.map((body, i) => between(body, b.ghost[i], t)) : b.ghost,
  };
}

function moment(frames, time) {
  let i = frames.length - 1;
  while (i > 0 && frames[i - 1].time > time) i--;
  if (i === 0) return frames[0];
  const [a, b] = [frames[i - 1], frames[i]];
  const span = b.time - a.time;
  return blend(a, b, span > 0 ? Math.min(1, Math.max(0, (time - a.time) / span)) : 1);
}

export class Course {
  constructor() {
    this.frames = [];
    this.time = 0;
    this.shot = null;
    this.replay = null;
    this.lost = 0;
    // Time between two frames [s].
    this.apart = 0.02;
    this.touchedAt = null;
  }

  // Time starts again: another match, another program.
  begin() {
    this.frames = [];
    this.touchedAt = null;
    if (this.shot) this.shot.until = -Infinity;
  }

  push(frame) {
    const before = this.newest;
    if (before && (frame.step < before.step || frame.time < before.time)) this.begin();
    const last = this.newest;
    if (last && frame.step === last.step) this.frames.pop();
    else if (last) this.lost += frame.step - last.step - 1;
    if (last && frame.time > last.time) this.apart += 0.2 * (Math.min(0.3, frame.time - last.time) - this.apart);
    if (frame.touched && !(last && last.touched)) this.touchedAt = frame.time;
    this.frames.push(frame);
    if (this.frames.length > KEPT) this.frames.splice(0, this.frames.length - KEPT);
  }

  get newest() {
    return this.frames[this.frames.length - 1];
  }

  // Keeps the shot that was just decided.
  keepShot() {
    const newest = this.newest;
    if (!newest) return;
    // A missed ball has no touch.
    const touch = this.touchedAt ?? newest.time - 1.5;
    this.touchedAt = null;
    const frames = this.frames.filter((f) => f.time >= touch - 1.1);
    // The ball continues into the net.
    this.shot = { frames, touch, until: newest.time + 0.7 };
  }

  startReplay() {
    const shot = this.shot;
    if (!shot) return false;
    const last = shot.frames[shot.frames.length - 1].time;
    const frames = shot.frames.concat(this.frames.filter((f) => f.time > last && f.time <= shot.until));
    this.replay = { frames, touch: shot.touch, time: frames[0].time };
    return true;
  }

  stopReplay() {
    this.replay = null;
  }

  // The moment to draw, `passed` seconds after the last one.
  at(passed) {
    if (this.replay) {
      const { frames, touch } = this.replay;
      // Slower around the touch.
      const near = Math.abs(this.replay.time - touch) < 0.25;
      this.replay.time += passed * (near ? 0.15 : 0.4);
      if (this.replay.time > frames[frames.length - 1].time + 0.1) this.replay = null;
      else return moment(frames, this.replay.time);
    }
    const newest = this.newest;
    if (!newest) return null;
    if (newest.paused) {
      this.time = newest.time;
      return newest;
    }
    const target = newest.time - Math.max(BEHIND * newest.rate, Math.min(0.25, APART * this.apart));
    this.time += passed * newest.kept;
    const off = target - this.time;
    this.time = Math.abs(off) > 0.3 ? target : this.time + off * 0.08;
    return moment(this.frames, this.time);
  }

  // Where the ball was in the last seconds before a moment [m].
  trail(time, seconds) {
    const frames = this.replay ? this.replay.frames : this.frames;
    return frames.filter((f) => f.time <= time && f.time > time - seconds).map((f) => f.ball.pos);
  }
}
