// Brings the parts together: link, course, view, hand, panel.

import { Course } from "./course.js";
import { hideCurves, showCurves } from "./curves.js";
import { Hand } from "./hand.js";
import { heading } from "./math.js";
import { Panel } from "./panel.js";
import { View } from "./view.js";
import { Link, command } from "./wire.js";

const canvas = document.getElementById("view");
const course = new Course();
const state = {
  moment: null,
  get replaying() {
    return course.replay !== null;
  },
  stopReplay,
};
let view, hand, panel, link;
let heat = [];
// Where the robot stood when the last kick began: the heat map is measured from there.
let stance = [0, 0, 0];
let before = null;
let pictures = 60;
let last = 0;
let reach = 0;
let told = 0;
let camera = null;
// A page that only watches can do nothing but stop.
const send = (bytes) => view.scene?.watched || link.send(bytes);

function stopReplay() {
  if (!course.replay && !camera) return;
  course.stopReplay();
  if (camera) Object.assign(view.camera, camera);
  camera = null;
  panel.setReplay(false);
}

function replay() {
  if (course.replay) return stopReplay();
  if (!course.startReplay()) return panel.say("There is no shot to replay yet.");
  camera = { ...view.camera };
  const moment = course.replay.frames[0];
  const towards = moment.goal[2];
  // From the goal's side, low, with ball and robot between.
  Object.assign(view.camera, {
    azimuth: towards + 0.62,
    elevation: 0.16,
    distance: 4.6,
    target: [moment.ball.pos[0] + 0.3 * Math.cos(towards), moment.ball.pos[1] + 0.3 * Math.sin(towards), 0.6],
  });
  panel.setReplay(true);
}

// The keyboard's hand: takes the ball, carries it, lets it go.
let carried = null;
let carriedAt = 0;
const actions = {
  replay,
  stopReplay,
  stop: () => link.send(command.stop()),
  follow() {
    hand.follow = !hand.follow;
    panel.setFollow(hand.follow);
  },
  orbit: (turn, raise) => hand.orbit(turn, raise),
  zoom: (factor) => hand.zoom(factor),
  nudge() {
    if (view.scene?.watched || view.scene?.kicks) return;
    const angle = 2 * Math.PI * Math.random();
    send(command.push([25 * Math.cos(angle), 25 * Math.sin(angle)]));
    panel.say("A push of 25 N s.");
  },
  carry(ahead, left) {
    if (!state.moment || view.scene?.watched || !view.scene?.ball) return;
    const towards = state.moment.goal[2];
    const [c, s] = [Math.cos(towards), Math.sin(towards)];
    const at = carried || [state.moment.ball.pos[0], state.moment.ball.pos[1]];
    carried = [at[0] + c * ahead - s * left, at[1] + s * ahead + c * left];
    carriedAt = performance.now();
    send(command.hold(carried));
  },
  letGo() {
    if (carried) send(command.drop(carried, [0, 0]));
    carried = null;
  },
};

function picture(now) {
  requestAnimationFrame(picture);
  const passed = Math.min(0.1, (now - last) / 1000);
  last = now;
  if (passed > 0) pictures += (1 / passed - pictures) * 0.05;
  adapt(now);
  const wasReplay = course.replay !== null;
  const moment = course.at(passed);
  if (!moment || !view.scene) return;
  if (wasReplay && !course.replay) stopReplay();
  state.moment = moment;
  hand.flush();
  if (!course.replay) hand.track(moment, passed);
  // The program has let go: a hand was silent for too long, or another ball came.
  if (carried && !course.newest.held && now - carriedAt > 500) carried = null;
  const held = hand.ball !== null || carried !== null;
  const begins = moment.kicking && !(before && before.kicking);
  if (held || begins) {
    const anchor = moment.bodies[view.scene.anchor];
    stance = [anchor.pos[0], anchor.pos[1], heading(anchor.quat)];
  }
  before = moment;
  reach += ((held ? 1 : 0) - reach) * Math.min(1, passed * 8);
  const { layers } = panel;
  view.draw(hand.ball && !course.replay ? inHand(moment) : moment, {
    ghost: layers.ghost,
    forces: layers.forces,
    belief: layers.belief,
    picture: layers.picture ? document.getElementById("picture-view") : null,
    trail: layers.trail && !held && view.scene.ball ? course.trail(moment.time, 1.6) : [],
    heat: Math.max(layers.heat ? 0.8 : 0, 0.5 * reach),
    reach,
    stance,
    push: hand.push,
  });
  if (view.picture) panel.setPicture(moment.belief && view.inPicture(moment.belief.pos), moment);
  panel.setPush(hand.push && hand.impulse());
  if (now - told > 200) {
    told = now;
    panel.setFrame(course.newest, pictures, course.lost);
    panel.setFollow(hand.follow);
  }
}

// The ball is where the hand is, not where it was when the program last heard of it.
function inHand(moment) {
  const [x, y] = hand.ball.at;
  return { ...moment, ball: { ...moment.ball, pos: [x, y, view.scene.ball_radius_m] } };
}

// Fewer pixels where drawing is slow.
let adapted = 3000;
function adapt(now) {
  if (now - adapted < 2000) return;
  adapted = now;
  if (pictures < 25 && view.detail > 0.5) view.detail -= 0.25;
}

async function start() {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  view = await View.create(canvas);
  view.dark = dark.matches;
  dark.addEventListener("change", () => (view.dark = dark.matches));
  panel = new Panel(send, actions);
  hand = new Hand(canvas, view, send, state);
  canvas.addEventListener("webglcontextlost", (e) => (e.preventDefault(), location.reload()));
  link = new Link({
    opened: hideCurves,
    scene(scene) {
      // Nothing of another scene is shown in this one.
      stopReplay();
      course.begin();
      course.shot = before = carried = null;
      document.body.classList.remove("waiting");
      document.body.classList.toggle("no-ball", !scene.ball);
      document.body.classList.toggle("watched", scene.watched);
      document.body.classList.toggle("bare", scene.bare);
      document.body.classList.toggle("motions", scene.kicks !== null);
      view.setScene(scene);
      panel.setScene(scene);
      panel.setGone(null);
      if (heat.length) view.setHeat(heat, scene.cells);
    },
    training(told) {
      showCurves(told);
      panel.setGone(null);
    },
    board(board) {
      heat = board.cells;
      if (panel.setBoard(board)) course.keepShot();
      if (view.scene) view.setHeat(heat, view.scene.cells);
    },
    frame: (frame) => course.push(frame),
    gone: (words) => panel.setGone(words),
  });
  // For tests, and for the curious.
  window.paid = { course, state, view, hand, panel, link, command };
  requestAnimationFrame(picture);
}

start().catch((error) => {
  document.getElementById("gone").hidden = false;
  document.getElementById("gone-words").textContent = error.message;
  console.error(error);
});
