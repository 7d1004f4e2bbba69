// Score, buttons, messages: everything that is text.

import { setKicks, showKicks } from "./kicks.js";
import { REMEMBERED } from "./view.js";
import { command } from "./wire.js";

const $ = (id) => document.getElementById(id);
const WORDS = { goal: "goal", wide: "wide", over: "over the bar", short: "short", no_contact: "missed the ball" };

export class Panel {
  constructor(send, actions) {
    this.send = send;
    this.actions = actions;
    this.shots = null;
    this.notice = null;
    this.layers = { ghost: false, forces: false, rewards: false, trail: true, heat: false, belief: false, picture: false };
    const click = (id, act) => $(id).addEventListener("click", () => (act(), $(id).blur()));
    click("pause", () => this.send(command.pause(!this.frame?.paused)));
    click("step", () => this.send(command.step()));
    click("another", () => this.send(command.another()));
    click("auto", () => this.send(command.auto(!this.frame?.auto)));
    click("fresh", () => this.send(command.fresh(!this.frame?.fresh)));
    click("replay", () => actions.replay());
    click("follow", () => actions.follow());
    click("stop", () => actions.stop());
    click("reset", () => this.send(command.reset()));
    click("clear", () => this.send(command.clear()));
    click("help", () => this.toggleHelp());
    click("help-close", () => this.toggleHelp(false));
    click("kicks-tab", () => showKicks());
    click("more", () => $("more").setAttribute("aria-expanded", String($("drawer").classList.toggle("open"))));
    $("rate").addEventListener("change", (e) => (this.send(command.rate(Number(e.target.value))), e.target.blur()));
    $("clip").addEventListener("change", (e) => (this.send(command.clip(Number(e.target.value))), e.target.blur()));
    $("engine").addEventListener("change", (e) => (this.send(command.engine(Number(e.target.value))), e.target.blur()));
    $("surface").addEventListener("change", (e) => (this.send(command.surface(Number(e.target.value))), e.target.blur()));
    for (const name of Object.keys(this.layers)) {
      // A browser may remember what was checked before a reload.
      $(`layer-${name}`).checked = this.layers[name];
      $(`layer-${name}`).addEventListener("change", (e) => {
        this.layers[name] = e.target.checked;
        this.showLayers();
      });
    }
    addEventListener("keydown", (e) => this.key(e));
  }

  showLayers() {
    $("rewards").hidden = !this.layers.rewards;
    $("picture").hidden = !this.layers.picture || !this.scene?.camera;
  }

  key(e) {
    if (e.ctrlKey || e.metaKey || e.altKey || e.target.tagName === "SELECT") return;
    const { send, actions, frame } = this;
    const layer = (name) => $(`layer-${name}`).click();
    const keys = {
      " ": () => send(command.pause(!frame?.paused)),
      ".": () => send(command.step()),
      k: () => send(command.another()),
      a: () => send(command.auto(!frame?.auto)),
      m: () => send(command.fresh(!frame?.fresh)),
      s: () => send(command.rate(frame && frame.rate < 1 ? 1 : 0.2)),
      e: () => send(command.engine(frame && frame.engine ? 0 : 1)),
      r: () => actions.replay(),
      f: () => actions.follow(),
      x: () => this.scene?.watched && actions.stop(),
      d: () => this.scene?.kicks && showKicks(),
      0: () => send(command.reset()),
      p: () => actions.nudge(),
      g: () => layer("ghost"),
      b: () => this.scene?.camera && layer("belief"),
      v: () => this.scene?.camera && layer("picture"),
      c: () => layer("forces"),
      w: () => layer("rewards"),
      t: () => layer("trail"),
      h: () => layer("heat"),
      "?": () => this.toggleHelp(),
      Escape: () => (this.toggleHelp(false), actions.stopReplay()),
      ArrowLeft: () => (e.shiftKey ? actions.carry(0, 0.1) : actions.orbit(-0.08, 0)),
      ArrowRight: () => (e.shiftKey ? actions.carry(0, -0.1) : actions.orbit(0.08, 0)),
      ArrowUp: () => (e.shiftKey ? actions.carry(0.1, 0) : actions.orbit(0, 0.06)),
      ArrowDown: () => (e.shiftKey ? actions.carry(-0.1, 0) : actions.orbit(0, -0.06)),
      Enter: () => actions.letGo(),
      "+": () => actions.zoom(0.9),
      "-": () => actions.zoom(1.11),
    };
    const act = keys[e.key] || keys[e.key.toLowerCase()];
    // A button, box or link under the focus is pressed by Space and Enter as everywhere.
    if (!act || (/^(BUTTON|INPUT|A)$/i.test(e.target.tagName) && (e.key === " " || e.key === "Enter"))) return;
    e.preventDefault();
    act();
  }

  toggleHelp(open = $("help-box").hidden) {
    $("help-box").hidden = !open;
    if (open) $("help-close").focus();
  }

  setScene(scene) {
    this.scene = scene;
    const clips = $("clip");
    clips.replaceChildren(new Option(scene.kicks ? "one after the other" : "by the ball", "-1"), ...scene.clips.map((name, i) => new Option(name, String(i))));
    $("engine").replaceChildren(...scene.engines.map((engine, i) => new Option(engine.name, String(i))));
    const surfaces = scene.surfaces.map(([name, what], i) => Object.assign(new Option(name, String(i + 1)), { title: what }));
    $("surface").replaceChildren(new Option("as it is", "0"), ...surfaces);
    $("what").textContent = `${scene.policy.split(/[\\/]/).slice(-2).join("/")} on ${scene.robot.toUpperCase()}`;
    $("seen").hidden = $("seen-picture").hidden = !scene.camera;
    this.showLayers();
    if (scene.camera) {
      const [a, b, , d] = scene.camera.corners;
      const far = (p, q) => Math.hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
      $("picture-view").style.aspectRatio = String(far(a, b) / far(a, d));
    }
    setKicks(scene.kicks);
    $("stop").hidden = !scene.watched;
    $("stop").title = `${scene.stop} (X)`;
    $("another").textContent = scene.ball ? "new ball" : "next clip";
    $("another").title = scene.ball ? "A ball at another position (K)" : "The next clip (K)";
    // What it follows is shown where there is nothing else to see.
    const follows = !scene.ball;
    if (follows !== Boolean(this.follows) && follows !== this.layers.ghost) $("layer-ghost").click();
    this.follows = follows;
    $("what").title = `${scene.policy}; knowledge: ${scene.knowledge}`;
    $("rewards").replaceChildren(
      ...scene.rewards.map((name) => {
        const row = document.createElement("div");
        const [label, bar, value] = ["span", "i", "b"].map((tag) => row.appendChild(document.createElement(tag)));
        label.textContent = name;
        Object.assign(row, { bar, value });
        return row;
      }),
    );
  }

  // True if a shot was decided since the last board.
  setBoard(board) {
    const before = this.shots;
    this.shots = board.shots;
    $("goals").textContent = board.goals;
    $("shots").textContent = board.shots;
    $("falls").textContent = board.falls === 1 ? "1 fall" : `${board.falls} falls`;
    $("list").replaceChildren(
      ...board.last.slice(0, 12).map((shot) => {
        const row = document.createElement("li");
        row.className = shot.outcome;
        const cells = [`${shot.number}`, WORDS[shot.outcome], `${shot.speed_m_s.toFixed(1)} m/s`, shot.outcome !== "goal" && shot.miss_m !== null ? `by ${shot.miss_m.toFixed(2)} m` : ""];
        for (const text of cells) row.appendChild(document.createElement("span")).textContent = text;
        row.title = `${shot.clip}, ${shot.engine}${shot.surface && `, ${shot.surface}`}${shot.rolling ? ", rolling" : ""}`;
        return row;
      }),
    );
    if (document.activeElement !== $("surface")) $("surface").value = String(board.surface);
    this.drawHeat(board.cells);
    const [number, words] = board.notice;
    if (words && number !== this.notice) this.say(words);
    this.notice = number;
    const decided = before !== null && board.shots > before;
    if (decided) {
      const shot = board.last[0];
      const speed = `${shot.speed_m_s.toFixed(1)} m/s`;
      const miss = shot.miss_m === null ? "" : ` by ${shot.miss_m.toFixed(2)} m`;
      const text = shot.outcome === "goal" ? `GOAL  ${speed}` : shot.outcome === "no_contact" ? "missed the ball" : `${WORDS[shot.outcome]}${miss}  ${speed}`;
      this.flash(text, shot.outcome === "goal");
    }
    return decided;
  }

  flash(text, good) {
    const box = $("flash");
    box.textContent = text;
    box.className = good ? "good" : "bad";
    // Restarts the animation.
    void box.offsetWidth;
    box.classList.add("on");
  }

  say(words) {
    const box = $("toast");
    box.textContent = words;
    box.classList.add("on");
    clearTimeout(this.saying);
    this.saying = setTimeout(() => box.classList.remove("on"), 3500);
  }

  drawHeat(cells) {
    const canvas = $("heat");
    const [rows, columns] = this.scene ? this.scene.cells : [7, 9];
    const size = 2 * Math.floor(canvas.clientWidth / columns) || 24;
    canvas.width = size * columns;
    canvas.height = size * rows;
    const ink = canvas.getContext("2d");
    cells.forEach(({ shots, goals }, i) => {
      const [row, column] = [Math.floor(i / columns), i % columns];
      // Ahead is up, left is left.
      const [x, y] = [(columns - 1 - column) * size, (rows - 1 - row) * size];
      const share = shots ? goals / shots : 0;
      ink.fillStyle = shots ? `hsl(${8 + 130 * share} 65% 45%)` : "rgba(128,140,150,0.18)";
      ink.beginPath();
      ink.roundRect(x + 2, y + 2, size - 4, size - 4, 5);
      ink.fill();
      if (shots) {
        ink.fillStyle = "#fff";
        ink.font = `600 ${Math.round(size * 0.4)}px system-ui`;
        ink.textAlign = "center";
        ink.textBaseline = "middle";
        ink.fillText(shots > 1 ? `${goals}/${shots}` : goals ? "✓" : "–", x + size / 2, y + size / 2 + 1);
      }
    });
  }

  setFrame(frame, pictures, lost) {
    this.frame = frame;
    const press = (id, on) => $(id).setAttribute("aria-pressed", String(on));
    $("pause").textContent = frame.paused ? "▶" : "❚❚";
    $("pause").title = frame.paused ? "Continue (Space)" : "Pause (Space)";
    press("pause", frame.paused);
    press("auto", frame.auto);
    press("fresh", !frame.fresh);
    const choose = (id, value) => {
      if (document.activeElement !== $(id)) $(id).value = value;
    };
    choose("clip", String(frame.clip));
    choose("engine", String(frame.engine));
    const nearest = [...$("rate").options].reduce((a, b) => (Math.abs(b.value - frame.rate) < Math.abs(a.value - frame.rate) ? b : a));
    choose("rate", nearest.value);
    const time = frame.paused
      ? "paused"
      : frame.late
        ? `slower than real time: ${frame.kept.toFixed(2)} of ${frame.rate.toFixed(2)}`
        : frame.rate < 1
          ? `slow motion, 1/${Math.round(1 / frame.rate)}`
          : "real time";
    $("status").textContent =
      time +
      // The cost of what runs elsewhere is unknown.
      (frame.cost ? ` · step ${frame.cost.toFixed(1)} ms` : "") +
      ` · ${Math.round(pictures)} frames/s` +
      (lost ? ` · ${lost} frames lost` : "") +
      (frame.viewers > 1 ? ` · ${frame.viewers} viewers` : "");
    $("status").classList.toggle("late", frame.late && !frame.paused);
    $("speed").textContent = frame.ballSpeed.toFixed(1);
    if (this.layers.rewards) this.drawRewards(frame.rewards);
  }

  drawRewards(rewards) {
    const rows = $("rewards").children;
    const most = Math.max(1e-6, ...rewards.map(Math.abs));
    rewards.forEach((x, i) => {
      const row = rows[i];
      if (!row) return;
      row.hidden = x === 0 && !row.paid;
      row.paid = row.paid || x !== 0;
      row.bar.style.width = `${(50 * Math.abs(x)) / most}%`;
      row.bar.style.left = x < 0 ? `${50 - (50 * Math.abs(x)) / most}%` : "50%";
      row.bar.className = x < 0 ? "cost" : "";
      row.value.textContent = x.toFixed(3);
    });
  }

  // The box in the robot's image: where it shows the estimated ball (null: nowhere), and the estimate.
  setPicture(box, moment) {
    const { belief, inView } = moment;
    const fresh = belief && belief.age < REMEMBERED;
    const mark = $("picture-box");
    mark.hidden = !box;
    mark.className = fresh ? "seen" : "kept";
    if (box) Object.assign(mark.style, { left: `${100 * box.x}%`, top: `${100 * box.y}%`, width: `${200 * box.half[0]}%`, height: `${200 * box.half[1]}%` });
    const words = !belief ? "no ball seen" : fresh ? "seen" : `remembered for ${belief.age.toFixed(1)} s`;
    $("picture-words").textContent = inView || !belief ? words : `${words}; out of view`;
  }

  setReplay(on) {
    $("replaying").hidden = !on;
    $("replay").setAttribute("aria-pressed", String(on));
  }

  setFollow(on) {
    $("follow").setAttribute("aria-pressed", String(on));
  }

  setPush(impulse) {
    const box = $("push");
    box.hidden = !impulse;
    if (impulse) box.textContent = `${Math.hypot(impulse[0], impulse[1]).toFixed(0)} N s`;
  }

  setGone(words) {
    $("gone").hidden = words === null;
    // From other machines it refuses pages without its token; a page cannot distinguish that from a program that has ended.
    const here = /^(localhost$|127\.|\[::1\])/.test(location.hostname);
    const away = here ? "The program is not running." : "The program is not running, or its address has another token now.";
    if (words !== null) $("gone-words").textContent = words || `${away} This page waits for it.`;
  }
}
