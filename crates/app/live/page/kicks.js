// What a set of kicks covers, next to the robot that shows them. The program draws the plots on request.

const $ = (id) => document.getElementById(id);

const WORDS = {
  coverage: "Which kick is used for which ball, and the holes",
  placement: "Where the task puts the ball of each kick",
  trajectories: "Paths of the base, colored by time",
  foot_speed: "Speed of the kicking foot over the phase",
};

function picture(name, query) {
  const box = document.createElement("figure");
  box.appendChild(document.createElement("figcaption")).textContent = WORDS[name] || name;
  const link = box.appendChild(document.createElement("a"));
  const image = link.appendChild(document.createElement("img"));
  link.href = image.src = `/kicks/${name}.svg${query}`;
  link.target = "_blank";
  image.alt = WORDS[name] || name;
  return box;
}

// The figures of a scene's kicks; null: it has none.
export function setKicks(kicks) {
  $("kicks-tab").hidden = !kicks;
  showKicks(Boolean(kicks));
  if (!kicks) return;
  $("kicks-share").textContent = kicks.share;
  $("kicks-advice").textContent = kicks.advice;
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  const query = token ? `?token=${encodeURIComponent(token)}` : "";
  $("kicks-pictures").replaceChildren(...kicks.pictures.map((name) => picture(name, query)));
}

export function showKicks(on = $("kicks").hidden) {
  $("kicks").hidden = !on;
  $("kicks-tab").setAttribute("aria-pressed", String(on));
  document.body.classList.toggle("beside", on);
}
