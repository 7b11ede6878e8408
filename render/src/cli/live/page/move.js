// How one moves: pointers, keys and the pad become orders.
"use strict";

// ---- Turns and steps ----------------------------------------------------------------------------------------------------------

/** Turns and steps are put together until the next frame of the screen. */
let turn = [0, 0];
let step = [0, 0, 0];
let waiting = false;

function flush() {
  waiting = false;
  const clamp = (x, most) => Math.max(-most, Math.min(most, x));
  if (turn[0] || turn[1]) send({ do: "turn", yaw: clamp(turn[0], 7), pitch: clamp(turn[1], 7) });
  if (step.some((x) => x)) {
    const [forward, right, up] = step.map((x) => clamp(x, 60));
    send({ do: "step", forward, right, up });
  }
  turn = [0, 0];
  step = [0, 0, 0];
}

function soon() {
  if (!waiting) {
    waiting = true;
    requestAnimationFrame(flush);
  }
}

/** Pixels of the screen to radian: what is seen follows the finger. */
function look(dx, dy) {
  const angle = (menu && menu.fov ? menu.fov : 0.8) / Math.max(1, canvas.clientWidth);
  turn[0] += dx * angle;
  turn[1] += dy * angle;
  soon();
}

function go(forward, right, up) {
  step[0] += forward;
  step[1] += right;
  step[2] += up;
  soon();
}

// ---- Pointers -----------------------------------------------------------------------------------------------------------------

const pointers = new Map();

function spread() {
  const [a, b] = [...pointers.values()];
  return { distance: Math.hypot(a.x - b.x, a.y - b.y), x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 };
}

canvas.addEventListener("pointerdown", (event) => {
  canvas.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, { x: event.clientX, y: event.clientY, aside: event.button === 2 });
  canvas.classList.add("held");
  canvas.focus({ preventScroll: true });
});

canvas.addEventListener("pointermove", (event) => {
  const pointer = pointers.get(event.pointerId);
  if (!pointer) return;
  const before = pointers.size === 2 ? spread() : null;
  const [dx, dy] = [event.clientX - pointer.x, event.clientY - pointer.y];
  pointer.x = event.clientX;
  pointer.y = event.clientY;
  const scale = 1.5 / Math.max(1, canvas.clientWidth);
  if (before) {
    const after = spread();
    go(1.5 * Math.log(Math.max(1, after.distance) / Math.max(1, before.distance)), (before.x - after.x) * scale, (after.y - before.y) * scale);
  } else if (pointers.size === 1) {
    if (pointer.aside || event.shiftKey) go(0, -dx * scale, dy * scale);
    else look(dx, dy);
  }
});

for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
  canvas.addEventListener(name, (event) => {
    pointers.delete(event.pointerId);
    if (!pointers.size) canvas.classList.remove("held");
  });
}

canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 30 : 1;
  go(Math.max(-1, Math.min(1, (-event.deltaY * lines) / 600)), 0, 0);
}, { passive: false });

// ---- Keys ---------------------------------------------------------------------------------------------------------------------

const WALKS = { KeyW: [1, 0, 0], KeyS: [-1, 0, 0], KeyA: [0, -1, 0], KeyD: [0, 1, 0], KeyE: [0, 0, 1], KeyQ: [0, 0, -1], PageUp: [0, 0, 1], PageDown: [0, 0, -1] };
const TURNS = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const SHORT = { KeyH: "home", KeyR: "record", KeyV: "mark", KeyP: "dots", KeyO: "zones", KeyN: "denoise" };
/** Radian in a second, by arrow keys. */
const TURNING = 0.9;
const USUAL = 0.4;

const held = new Set();
const pads = new Map();
let fast = false;
let walked = "";
let turning = 0;

/** Tells what keys and buttons that are held add up to. */
function walk() {
  const sum = [0, 0, 0];
  const ways = [...held].map((key) => WALKS[key]).concat([...pads.values()]).filter(Boolean);
  for (const way of ways) way.forEach((x, i) => { sum[i] += x; });
  const speed = fast ? 1 : USUAL;
  const [forward, right, up] = sum.map((x) => Math.max(-1, Math.min(1, x)) * speed);
  const order = JSON.stringify([forward, right, up]);
  if (order !== walked) {
    walked = order;
    send({ do: "walk", forward, right, up });
  }
}

function turnOn(now) {
  const ways = [...held].map((key) => TURNS[key]).filter(Boolean);
  if (!ways.length) {
    turning = 0;
    return;
  }
  const seconds = turning ? Math.min(0.1, (now - turning) / 1000) : 1 / 60;
  turning = now;
  for (const [yaw, pitch] of ways) {
    turn[0] += yaw * TURNING * seconds;
    turn[1] += pitch * TURNING * seconds;
  }
  flush();
  requestAnimationFrame(turnOn);
}

/** Sliders and lists have keys of their own. */
function typing(target) {
  return target.closest("select, textarea, input[type=range], dialog");
}

addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || typing(event.target)) return;
  fast = event.shiftKey;
  if (event.key === "?") {
    $("help").showModal();
  } else if (WALKS[event.code]) {
    held.add(event.code);
    walk();
  } else if (TURNS[event.code]) {
    held.add(event.code);
    if (!turning) requestAnimationFrame(turnOn);
  } else if (SHORT[event.code] && !event.repeat) {
    $(SHORT[event.code]).click();
  } else {
    if (event.key === "Shift") walk();
    return;
  }
  event.preventDefault();
});

addEventListener("keyup", (event) => {
  fast = event.shiftKey;
  held.delete(event.code);
  walk();
});

function still() {
  held.clear();
  pads.clear();
  walk();
}
addEventListener("blur", still);
document.addEventListener("visibilitychange", () => { if (document.hidden) still(); });

for (const button of document.querySelectorAll(".pad button")) {
  const way = button.dataset.walk.split(",").map(Number);
  button.addEventListener("pointerdown", (event) => {
    button.setPointerCapture(event.pointerId);
    pads.set(button, way);
    walk();
  });
  for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
    button.addEventListener(name, () => { pads.delete(button); walk(); });
  }
  button.addEventListener("contextmenu", (event) => event.preventDefault());
  // By keyboard or a reader of the screen: one step.
  button.addEventListener("click", (event) => { if (!event.detail) go(...way.map((x) => 0.3 * x)); });
}
