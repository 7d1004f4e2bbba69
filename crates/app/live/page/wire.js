// The messages between page and program. The tables stand in the documentation of the Rust types `Frame` and `Command`.

export const VERSION = 2;

// A moment of the scene; null if the message is none of this version.
export function decode(buffer) {
  const view = new DataView(buffer);
  if (buffer.byteLength < 72 || view.getUint8(0) !== VERSION || view.getUint8(1) !== 1) return null;
  const f32 = (at) => view.getFloat32(at, true);
  const quat = (at) => [0, 2, 4, 6].map((k) => view.getInt16(at + k, true) / 32767);
  const [bodies, ghosts, forces, rewards] = [64, 65, 66, 67].map((at) => view.getUint8(at));
  const bits = view.getUint16(2, true);
  const believes = (bits >> 9) & 1;
  if (buffer.byteLength !== 72 + 20 * (bodies + ghosts) + 7 * forces + 4 * rewards + 20 * believes) return null;
  const flag = (k) => ((bits >> k) & 1) === 1;
  let at = 72;
  const list = (count) => {
    const out = [];
    for (let i = 0; i < count; i++, at += 20)
      out.push({ pos: [f32(at), f32(at + 4), f32(at + 8)], quat: quat(at + 12) });
    return out;
  };
  const frame = {
    paused: flag(0),
    auto: flag(1),
    fallen: flag(2),
    late: flag(3),
    touched: flag(4),
    kicking: flag(5),
    held: flag(6),
    fresh: flag(7),
    inView: flag(8),
    step: view.getUint32(4, true),
    time: view.getFloat64(8, true),
    rate: f32(16),
    kept: f32(20),
    ball: { pos: [f32(24), f32(28), f32(32)], quat: quat(40) },
    ballSpeed: f32(36),
    goal: [f32(48), f32(52), f32(56)],
    engine: view.getUint8(60),
    viewers: view.getUint8(61),
    clip: view.getInt16(62, true),
    cost: f32(68),
    bodies: list(bodies),
    ghost: list(ghosts),
    forces: [],
    rewards: [],
    belief: null,
  };
  for (let i = 0; i < forces; i++, at += 7)
    frame.forces.push({ body: view.getUint8(at), newton: [1, 3, 5].map((k) => view.getInt16(at + k, true)) });
  for (let i = 0; i < rewards; i++, at += 4) frame.rewards.push(f32(at));
  if (believes) frame.belief = { pos: [f32(at), f32(at + 4), f32(at + 8)], deviation: f32(at + 12), age: f32(at + 16) };
  return frame;
}

function message(kind, bytes) {
  const view = new DataView(new ArrayBuffer(2 + bytes));
  view.setUint8(0, VERSION);
  view.setUint8(1, kind);
  return view;
}

function floats(kind, values) {
  const view = message(kind, 4 * values.length);
  values.forEach((x, i) => view.setFloat32(2 + 4 * i, x, true));
  return view.buffer;
}

function byte(kind, value) {
  const view = message(kind, 1);
  view.setUint8(2, Number(value));
  return view.buffer;
}

export const command = {
  hold: (at) => floats(1, at),
  drop: (at, velocity) => floats(2, [...at, ...velocity]),
  goal: (at) => floats(3, at),
  push: (impulse) => floats(4, impulse),
  clip: (number) => {
    const view = message(5, 2);
    view.setInt16(2, number, true);
    return view.buffer;
  },
  pause: (on) => byte(6, on),
  step: () => message(7, 0).buffer,
  rate: (rate) => floats(8, [rate]),
  engine: (engine) => byte(9, engine),
  auto: (on) => byte(10, on),
  reset: () => message(11, 0).buffer,
  clear: () => message(12, 0).buffer,
  fresh: (on) => byte(13, on),
  another: () => message(14, 0).buffer,
  surface: (number) => byte(15, number),
  stop: () => message(16, 0).buffer,
};

// Keeps the connection, also over a restart of the program.
export class Link {
  constructor(on) {
    this.on = on;
    this.socket = null;
    this.open();
  }

  open() {
    const token = new URLSearchParams(location.hash.slice(1)).get("token");
    const query = token ? `?token=${encodeURIComponent(token)}` : "";
    const socket = new WebSocket(`ws://${location.host}/ws${query}`);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => this.on.opened();
    socket.onmessage = (event) => {
      if (typeof event.data !== "string") {
        const frame = decode(event.data);
        if (frame) this.on.frame(frame);
        return;
      }
      const text = JSON.parse(event.data);
      if (text.kind === "scene") {
        if (text.version !== VERSION) return this.reload();
        this.on.scene(text);
      } else if (text.kind === "board") this.on.board(text);
      else if (text.kind === "training") this.on.training(text);
    };
    socket.onclose = (event) => {
      if (event.code === 4001) return this.reload();
      this.on.gone(event.code === 4002 ? event.reason : "");
      setTimeout(() => this.open(), 1000);
    };
  }

  // The program speaks another version: its page is another one, too. Once a minute is enough.
  reload() {
    const last = Number(sessionStorage.getItem("reloaded") || 0);
    if (Date.now() - last < 60000) return this.on.gone("The program has another version. Reload this page.");
    sessionStorage.setItem("reloaded", String(Date.now()));
    location.reload();
  }

  send(bytes) {
    if (this.socket && this.socket.readyState === WebSocket.OPEN) this.socket.send(bytes);
  }
}
