'use strict';

// One camera's knobs, its pixels around a point, and presets of all cameras.
const focus = { camera: -1, serial: '', x: 0.5, y: 0.5, timer: 0, offered: '', knobs: [] };
const kLow = 4, kHigh = 251;    // of 255: clipped
const kEdge = 48;               // difference of neighbours that peaking shows

function pointOn(canvas, event) {
  const box = canvas.getBoundingClientRect();
  const scale = Math.min(box.width / canvas.width, box.height / canvas.height);
  const x = (event.clientX - box.left - (box.width - scale * canvas.width) / 2) / (scale * canvas.width);
  const y = (event.clientY - box.top - (box.height - scale * canvas.height) / 2) / (scale * canvas.height);
  return { x: Math.min(1, Math.max(0, x)), y: Math.min(1, Math.max(0, y)) };
}

function openFocus(camera, serial, x, y) {
  const other = focus.camera !== camera;
  Object.assign(focus, { camera, serial, x, y });
  put($('focus-title'), 'Camera ' + serial);
  $('focus').hidden = false;
  if (other) {
    put($('knob-error'), '');
    readKnobs().catch(() => {});
  }
  clearTimeout(focus.timer);
  look();
  $('focus').scrollIntoView({ block: 'nearest' });
}

async function look() {
  const camera = focus.camera;
  if (camera < 0) return;
  try {
    const response = await fetch(`api/zoom?camera=${camera}&x=${focus.x.toFixed(4)}&y=${focus.y.toFixed(4)}`);
    if (response.ok && !document.hidden) paint(await createImageBitmap(await response.blob()));
  } catch (error) { /* the status line says that the node is away */ }
  if (focus.camera === camera) focus.timer = setTimeout(look, 200);
}

// Peaking: edges in green. Clipping: what is white in red, what is black in blue.
function paint(picture) {
  const canvas = $('zoom');
  canvas.width = picture.width;
  canvas.height = picture.height;
  const context = canvas.getContext('2d', { willReadFrequently: true });
  context.drawImage(picture, 0, 0);
  const w = canvas.width, h = canvas.height, image = context.getImageData(0, 0, w, h), p = image.data;
  const grey = new Uint8Array(w * h), counts = new Uint32Array(256);
  for (let i = 0; i < w * h; ++i) {
    grey[i] = (54 * p[4 * i] + 183 * p[4 * i + 1] + 19 * p[4 * i + 2]) >> 8;
    ++counts[grey[i]];
  }
  const peaking = $('peaking').checked, clipping = $('clipping').checked;
  let edges = 0;
  for (let y = 1; y < h - 1; ++y)
    for (let x = 1; x < w - 1; ++x) {
      const i = y * w + x, at = 4 * i;
      const edge = Math.abs(grey[i + 1] - grey[i - 1]) + Math.abs(grey[i + w] - grey[i - w]);
      edges += edge * edge;
      const mark = (r, g, b) => { p[at] = r; p[at + 1] = g; p[at + 2] = b; };
      if (clipping && Math.max(p[at], p[at + 1], p[at + 2]) >= kHigh && grey[i] > 128) mark(255, 40, 40);
      else if (clipping && grey[i] <= kLow) mark(40, 60, 255);
      else if (peaking && edge > kEdge) mark(60, 255, 90);
    }
  context.putImageData(image, 0, 0);
  put($('sharpness'), 'Sharpness ' + Math.sqrt(edges / (w * h)).toFixed(1));
  drawHistogram(counts);
}

function drawHistogram(counts) {
  const canvas = $('histogram'), context = canvas.getContext('2d');
  const most = Math.max(1, ...counts.slice(kLow + 1, kHigh));
  context.clearRect(0, 0, canvas.width, canvas.height);
  for (let v = 0; v < 256; ++v) {
    const tall = Math.min(1, counts[v] / most) * canvas.height;
    context.fillStyle = v >= kHigh ? '#ff5050' : v <= kLow ? '#5070ff' : '#c8c8c8';
    context.fillRect(v * canvas.width / 256, canvas.height - tall, canvas.width / 256, tall);
  }
}

// As the cameras are, beside what the operator is turning just now; `all`: that, too.
async function readKnobs(all = false) {
  const response = await fetch('api/controls');
  if (!response.ok) return;
  const studio = await response.json();
  showPresets(studio.presets);
  if (studio.trouble) put($('knob-error'), studio.trouble, 'is-bad');
  const camera = studio.cameras.find((c) => c.serial === focus.serial);
  const controls = camera ? camera.controls : [];
  const offered = JSON.stringify([focus.serial, controls.map((c) => ({ ...c, value: 0 }))]);
  if (focus.offered !== offered) {
    focus.offered = offered;
    focus.knobs = controls.map(makeKnob);
    $('knobs').replaceChildren(...focus.knobs.map((knob) => knob.root));
    if (!controls.length) $('knobs').textContent = 'This camera has nothing to set while it streams.';
  }
  focus.knobs.forEach((knob, i) => knob.show(controls[i].value, all));
}

function showPresets(names) {
  const key = names.join(' ');
  if ($('preset-names').dataset.key === key) return;
  $('preset-names').dataset.key = key;
  $('preset-names').replaceChildren(...names.map((name) => {
    const option = document.createElement('option');
    option.value = name;
    return option;
  }));
}

// Ranges of a thousandfold, as exposures have, are turned by their logarithm.
function makeKnob(control) {
  const { name, least, most, step } = control;
  const log = least > 0 && most / least >= 1000;
  const to = (v) => log ? Math.log(v) : v, from = (v) => log ? Math.exp(v) : v;
  const rounded = (v) => {
    const stepped = step ? least + Math.round((v - least) / step) * step : Number(v.toPrecision(4));
    return Math.min(most, Math.max(least, stepped));
  };
  const slider = document.createElement('input'), number = document.createElement('input');
  Object.assign(slider, { type: 'range', min: to(least), max: to(most), step: step && !log ? step : 'any' });
  slider.setAttribute('aria-label', name + ', slider');
  Object.assign(number, { type: 'number', step: 'any', min: least, max: most, name });
  slider.addEventListener('input', () => { number.value = rounded(from(Number(slider.value))); });
  slider.addEventListener('change', () => turn(name, rounded(from(Number(slider.value)))));
  number.addEventListener('change', () => turn(name, Number(number.value)));
  const root = document.createElement('label');
  root.append(span('', name), number, slider);
  const show = (value, always) => {
    const held = document.activeElement === slider || document.activeElement === number;
    if (held && !always) return;
    number.value = Number(value.toPrecision(6));
    slider.value = to(value);
  };
  return { root, show };
}

async function order(path) {
  try {
    const response = await fetch(path, { method: 'POST' });
    const answer = await response.json();
    put($('knob-error'), response.ok ? '' : answer.error, response.ok ? '' : 'is-bad');
  } catch (error) {
    put($('knob-error'), 'The node does not answer.', 'is-bad');
  }
  readKnobs(true).catch(() => {});
}

const turn = (name, value) =>
  order(`api/control?camera=${encodeURIComponent(focus.serial)}&name=${encodeURIComponent(name)}&value=${value}`);

$('knobs').addEventListener('submit', (event) => event.preventDefault());
$('presets').addEventListener('submit', (event) => {
  event.preventDefault();
  order(`api/preset/${event.submitter.value}?name=${encodeURIComponent($('preset').value.trim())}`);
});
$('zoom').addEventListener('click', (event) => {
  // In the picture the piece is never over the edge.
  const at = pointOn($('zoom'), event), picture = tiles[focus.camera];
  const moved = (centre, by, piece, whole) => {
    const half = Math.min(0.5, piece / whole / 2), from = Math.min(1 - half, Math.max(half, centre));
    return Math.min(1, Math.max(0, from + (by - 0.5) * 2 * half));
  };
  focus.x = moved(focus.x, at.x, $('zoom').width, picture.width);
  focus.y = moved(focus.y, at.y, $('zoom').height, picture.height);
});
$('focus-close').addEventListener('click', () => {
  focus.camera = -1;
  clearTimeout(focus.timer);
  $('focus').hidden = true;
});
setInterval(() => {  // automatics turn knobs, and so do others
  if (focus.camera >= 0 && !document.hidden) readKnobs().catch(() => {});
}, 2000);
