// The page of `render view`: sends orders, shows frames. What it shows of the settings is what the view says, not what was clicked.
"use strict";

const $ = (id) => document.getElementById(id);
const canvas = $("picture");
const context = canvas.getContext("2d", { alpha: false });

/** What the view offers, and what it said last. */
let menu = null;
let status = null;
let socket = null;
/** Rows of saved views, as CSV without header. */
let header = "";
let saved = [];

const STAGES = { preparing: "Getting ready …", moving: "Moving", filling: "Filling", refining: "Refining", settled: "Ready" };
/** Frames between saved views when they are drawn as a path: two seconds. */
const APART = 48;

function send(order) {
  if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(order));
}

// ---- Settings -----------------------------------------------------------------------------------------------------------------

/** The slider of τ is logarithmic. */
const tauOf = (x) => menu.taus[0] * (menu.taus[1] / menu.taus[0]) ** (x / 100);
const placeOf = (tau) => (100 * Math.log(tau / menu.taus[0])) / Math.log(menu.taus[1] / menu.taus[0]);
const short = (x) => String(Number(x.toPrecision(2)));

$("method").addEventListener("change", () => send({ do: "method", name: $("method").value }));
$("interpolation").addEventListener("change", () => send({ do: "interpolation", name: $("interpolation").value }));
$("look").addEventListener("change", () => send({ do: "view", name: $("look").value }));
$("tau").addEventListener("input", () => { $("tau-out").value = short(tauOf($("tau").value)); });
$("tau").addEventListener("change", () => send({ do: "tau", tau: Number(tauOf($("tau").value).toPrecision(2)) }));
$("stops").addEventListener("input", () => send({ do: "exposure", stops: Number($("stops").value) }));
$("denoise").addEventListener("change", () => send({ do: "denoise", on: $("denoise").checked }));
for (const id of ["dots", "zones"]) {
  $(id).addEventListener("change", () => send({ do: "marks", dots: $("dots").checked, zones: $("zones").checked }));
}
$("home").addEventListener("click", () => send({ do: "home" }));
$("slower").addEventListener("click", () => send({ do: "hurry", factor: 0.5 }));
$("faster").addEventListener("click", () => send({ do: "hurry", factor: 2 }));
$("mark").addEventListener("click", () => send({ do: "mark" }));
$("record").addEventListener("click", () => send({ do: "record", on: !(status && status.recording !== null) }));
$("help-open").addEventListener("click", () => $("help").showModal());
$("panel-toggle").addEventListener("click", () => {
  const open = $("panel").classList.toggle("open");
  $("panel-toggle").setAttribute("aria-expanded", open);
  $("panel-toggle").textContent = open ? "Close" : "Settings";
});

// ---- Saved views --------------------------------------------------------------------------------------------------------------

const path = () => [header, ...saved.map((row, i) => `${1 + APART * i},${row}`)].join("\n") + "\n";

function showSaved() {
  $("saved").hidden = !saved.length;
  $("saved-count").value = saved.length === 1 ? "1 saved view" : `${saved.length} saved views, two seconds apart`;
  $("saved-line").value = path();
  $("saved-line").scrollTop = $("saved-line").scrollHeight;
}

function download(name, text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

$("copy").addEventListener("click", async () => {
  try {
    await navigator.clipboard.writeText(path());
    notice("Copied.");
  } catch {
    $("saved-line").select();
    notice("The browser does not let pages copy: the text is selected.");
  }
});
$("download").addEventListener("click", () => download("views.csv", path()));
$("forget").addEventListener("click", () => { saved = []; showSaved(); });

// ---- What is told -------------------------------------------------------------------------------------------------------------

let noticed = 0;
function notice(text, stays = false, wrong = stays) {
  clearTimeout(noticed);
  $("notice").classList.toggle("wrong", wrong);
  $("notice").hidden = !text;
  $("notice").textContent = text;
  if (text && !stays) noticed = setTimeout(() => { $("notice").hidden = true; }, 5000);
}

/** Who sums the records of a pixel, by name. */
const SUMMED = { auto: "the faster way", octree: "pixels look", splat: "drawn on tiles", gpu: "graphics card" };

function offer(told) {
  menu = told;
  document.title = `${menu.scene} – Burnish`;
  $("scene").textContent = menu.scene;
  $("scene").title = menu.scene;
  $("method").replaceChildren(...menu.methods.map(([name]) => new Option(name, name)));
  $("interpolation").replaceChildren(...menu.interpolations.map((name) => new Option(SUMMED[name], name)));
  $("denoise").disabled = !menu.denoiser;
  $("denoiser").textContent = menu.denoiser ? `(${menu.denoiser})` : "(no denoiser)";
  [canvas.width, canvas.height] = menu.size;
  fit();
}

/** Sets what a control shows, unless it is in somebody's hand. */
function set(id, key, value) {
  if (document.activeElement !== $(id) || $(id).type === "checkbox") $(id)[key] = value;
}

/** What the last message of the view was: it is shown once. */
let message = null;

function tell(told) {
  status = told;
  const cached = told.method !== "path";
  const filling = told.stage === "filling";
  $("stage").textContent = STAGES[told.stage] + (filling ? ` ${Math.round(100 * told.filled)} %` : "");
  $("fps").textContent = told.stage === "settled" || !told.fps ? "" : `${told.fps.toFixed(1)} frames/s`;
  $("size").textContent = told.size[0] ? `${told.size[0]} × ${told.size[1]} pixels` : "";
  $("spp").textContent = `${told.spp[0]} of ${told.spp[1]} samples`;
  $("records").textContent = cached ? `${told.records.toLocaleString("en")} records, ${(told.bytes / 1e6).toFixed(1)} MB` : "no records";
  const share = filling ? told.filled : told.stage === "moving" ? 0 : told.spp[0] / Math.max(1, told.spp[1]);
  $("share").firstElementChild.style.width = `${100 * share}%`;
  $("share").setAttribute("aria-valuenow", Math.round(100 * share));
  $("share").classList.toggle("done", told.stage === "settled" || told.stage === "moving");
  set("method", "value", told.method);
  const about = menu.methods.find(([name]) => name === told.method);
  $("about").textContent = about ? about[1].split(";")[0] : "";
  $("tau").disabled = $("interpolation").disabled = !cached;
  set("interpolation", "value", told.interpolation);
  set("tau", "value", placeOf(told.tau));
  if (document.activeElement !== $("tau")) $("tau-out").value = short(told.tau);
  set("stops", "value", told.stops);
  $("stops-out").value = `${told.stops > 0 ? "+" : ""}${Number(told.stops.toFixed(1))} EV`;
  set("look", "value", told.view);
  set("denoise", "checked", told.denoise);
  set("dots", "checked", told.marks[0]);
  set("zones", "checked", told.marks[1]);
  $("dots").disabled = $("zones").disabled = !cached;
  const recording = told.recording !== null;
  $("record").setAttribute("aria-pressed", recording);
  $("record").textContent = recording ? "End recording" : "Record walk";
  if (told.message !== message) notice(told.message, true);
  message = told.message;
}

function answer(told) {
  if (told.tell === "error") notice(told.message, false, true);
  if (told.tell === "view") {
    const [first, row] = told.csv.split("\n");
    header = first;
    saved.push(row.slice(row.indexOf(",") + 1));
    showSaved();
    notice("The view is saved: see “Camera”.");
  }
  if (told.tell === "walk") {
    download("walk.csv", told.csv);
    notice(menu.record ? `The walk is in ${menu.record}, and among your downloads.` : "The walk is among your downloads.");
  }
}

// ---- Frames -------------------------------------------------------------------------------------------------------------------

/** The canvas as large as it fits, in the shape of the film. */
function fit() {
  if (!menu) return;
  const stage = canvas.parentElement;
  const scale = Math.min(stage.clientWidth / menu.size[0], stage.clientHeight / menu.size[1]);
  canvas.style.width = `${Math.floor(menu.size[0] * scale)}px`;
  canvas.style.height = `${Math.floor(menu.size[1] * scale)}px`;
}
new ResizeObserver(fit).observe(canvas.parentElement);

let drawing = false;
let next = null;

/** Decodes and shows a frame; of those that come meanwhile the last. */
async function draw(bytes) {
  if (drawing) {
    next = bytes;
    return;
  }
  drawing = true;
  try {
    const image = await createImageBitmap(new Blob([bytes], { type: "image/jpeg" }));
    context.imageSmoothingQuality = "high";
    context.drawImage(image, 0, 0, canvas.width, canvas.height);
    image.close();
    canvas.dataset.frames = Number(canvas.dataset.frames || 0) + 1;
  } catch {
    notice("A frame came broken.");
  }
  drawing = false;
  if (next) {
    const bytes = next;
    next = null;
    draw(bytes);
  }
}

/** Seconds between attempts to come back. */
const AGAIN = 1.5;

function connect() {
  const address = new URL("socket", location.href);
  address.protocol = "ws:";
  socket = new WebSocket(address);
  socket.binaryType = "arraybuffer";
  let open = false;
  socket.onopen = () => {
    open = true;
    notice("");
    walked = "";
  };
  socket.onmessage = ({ data }) => {
    if (typeof data !== "string") return void draw(data);
    const told = JSON.parse(data);
    if (told.tell === "menu") offer(told);
    else if (told.tell === "status") tell(told);
    else answer(told);
  };
  socket.onclose = ({ reason }) => {
    $("stage").textContent = "Not connected";
    $("fps").textContent = "";
    if (reason) {
      notice(`${reason[0].toUpperCase()}${reason.slice(1)}. Load this page again to come back.`, true);
      return;
    }
    notice("The view does not answer: is render still running?", true);
    if (open) setTimeout(connect, 1000 * AGAIN);
  };
}

connect();
