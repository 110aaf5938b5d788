'use strict';

const $ = (id) => document.getElementById(id);
const tiles = [];      // by the camera's number: {root, canvas, …}
let recording = false;
let lastTake = null;   // whose end makes the list be read again
let commandError = '';

const clock = (seconds) => {
  const s = Math.max(0, Math.floor(seconds));
  const two = (n) => String(n).padStart(2, '0');
  const h = Math.floor(s / 3600);
  return (h ? h + ':' : '') + two(Math.floor(s / 60) % 60) + ':' + two(s % 60);
};
const bytes = (n) => n >= 1e12 ? (n / 1e12).toFixed(2) + ' TB' : n >= 1e9 ? (n / 1e9).toFixed(1) + ' GB' : (n / 1e6).toFixed(0) + ' MB';
const duration = (minutes) => minutes >= 120 ? Math.floor(minutes / 60) + ' h' : Math.floor(minutes) + ' min';

// Writes only what changed, so that nothing is announced twice and nothing is laid out in vain.
function put(element, text, className = '') {
  if (element.textContent !== text) element.textContent = text;
  if (element.className !== className) element.className = className;
}

function putFigure(id, main, small = '', className = '') {
  const element = $(id);
  const key = main + '|' + small;
  if (element.dataset.key !== key) {
    element.dataset.key = key;
    element.textContent = main;
    if (small) {
      const extra = document.createElement('small');
      extra.textContent = ' ' + small;
      element.append(extra);
    }
  }
  if (element.className !== className) element.className = className;
}

function makeTile(camera, index) {
  const root = $('tile').content.cloneNode(true).querySelector('li');
  const tile = {
    root,
    width: camera.width || 320,  // px of its pictures
    height: camera.height || 240,
    canvas: root.querySelector('canvas'),
    trouble: root.querySelector('.trouble'),
    fps: root.querySelector('.fps'),
    facts: root.querySelector('.facts'),
  };
  root.querySelector('.serial').textContent = camera.serial;
  tile.canvas.setAttribute('aria-label', 'Preview of camera ' + camera.serial);
  tile.canvas.addEventListener('click', (event) => {
    const at = pointOn(tile.canvas, event);
    openFocus(index, camera.serial, at.x, at.y);
  });
  const adjust = root.querySelector('.adjust');
  adjust.setAttribute('aria-label', 'Adjust camera ' + camera.serial);
  adjust.addEventListener('click', () => openFocus(index, camera.serial, 0.5, 0.5));
  if (camera.width && camera.height)
    root.querySelector('.picture').style.aspectRatio = camera.width + ' / ' + camera.height;
  $('tiles').append(root);
  return tile;
}

function showCamera(camera, index, nominal) {
  if (!tiles[index]) tiles[index] = makeTile(camera, index);
  const tile = tiles[index];
  const slow = Math.abs(camera.fps - nominal) > 0.02 * nominal;
  put(tile.fps, camera.fps.toFixed(1) + ' fps', slow ? 'fps is-warn' : 'fps');
  tile.trouble.hidden = !camera.trouble;
  put(tile.trouble, camera.trouble, 'trouble');
  tile.root.classList.toggle('has-trouble', !!camera.trouble);
  const facts = [[camera.lost + ' lost', camera.lost > 0 ? 'is-warn' : '']];
  if (camera.failed) facts.push([camera.failed + ' failed', 'is-warn']);
  if (camera.starved) facts.push([camera.starved + ' starved', 'is-warn']);
  if (camera.reconnects) facts.push([camera.reconnects + ' reconnects', 'is-warn']);
  if (camera.bandwidth_mbit !== undefined) facts.push([(camera.bandwidth_mbit / 8).toFixed(1) + ' MB/s', '']);
  if (camera.temperature_c !== undefined)
    facts.push([camera.temperature_c.toFixed(0) + ' °C', camera.temperature_c > 75 ? 'is-warn' : '']);
  const key = JSON.stringify(facts);
  if (tile.facts.dataset.key === key) return;
  tile.facts.dataset.key = key;
  tile.facts.replaceChildren(...facts.map(([text, className]) => {
    const span = document.createElement('span');
    span.textContent = text;
    span.className = className;
    return span;
  }));
}

function showNotes(status) {
  const notes = [];
  if (commandError) notes.push([commandError, true]);
  if (status.last_recording) notes.push([status.last_recording, true]);
  if (status.recording) for (const c of status.recording.complaints) notes.push(['This take: ' + c, false]);
  else for (const c of status.complaints) notes.push([c, false]);
  const box = $('notes');
  const key = JSON.stringify(notes);
  if (box.dataset.key === key) return;
  box.dataset.key = key;
  box.hidden = notes.length === 0;
  const shown = notes.slice(0, 2).map(([text, bad]) => {
    const p = document.createElement('p');
    p.textContent = text;
    if (bad) p.className = 'is-error';
    return p;
  });
  if (notes.length > 2) {
    const more = document.createElement('p');
    more.textContent = 'and ' + (notes.length - 2) + ' more';
    shown.push(more);
  }
  box.replaceChildren(...shown);
}

function setState(state, text) {
  $('state').dataset.state = state;
  put($('state'), text, 'state');
}

// The loudest track's level under full scale; one that is clipped, silent or gone is marked.
function showSound(sounds) {
  $('sound-figure').hidden = sounds.length === 0;
  if (sounds.length === 0) return;
  const ended = sounds.filter((s) => s.ended).length;
  const peak = Math.max(...sounds.map((s) => s.peak));
  const level = peak > 1e-4 ? Math.round(20 * Math.log10(peak)) + ' dB' : 'silent';
  putFigure('sound', level, ended ? ended + ' of ' + sounds.length + ' ended' : sounds.length > 1 ? sounds.length + ' tracks' : '',
            ended ? 'is-bad' : peak > 0.99 || peak <= 1e-4 ? 'is-warn' : '');
}

function show(status) {
  put($('node'), status.node);
  document.title = (status.recording ? '● ' : '') + status.node + ' – Floatstage';
  status.cameras.forEach((camera, i) => showCamera(camera, i, status.fps));
  const up = status.cameras.filter((c) => !c.trouble).length;
  putFigure('cameras-up', up + ' of ' + status.cameras.length, '', up < status.cameras.length ? 'is-bad' : '');
  putFigure('spread', status.spread_ms.p50.toFixed(2) + ' ms', 'max ' + status.spread_ms.max.toFixed(2));
  const lost = status.cameras.reduce((sum, c) => sum + c.lost, 0);
  putFigure('dropped', String(lost), status.recording ? status.recording.gaps + ' in take' : '', lost ? 'is-warn' : '');
  const rate = status.cameras.reduce((sum, c) => sum + (c.bandwidth_mbit || 0), 0) / 8;
  putFigure('rate', rate.toFixed(0) + ' MB/s');
  const minutes = status.disk_minutes;
  putFigure('disk', minutes === undefined ? bytes(status.disk_free_bytes) : duration(minutes),
            minutes === undefined ? '' : bytes(status.disk_free_bytes) + ' free',
            minutes !== undefined && minutes < 5 ? 'is-bad' : minutes !== undefined && minutes < 20 ? 'is-warn' : '');
  putFigure('preroll', status.preroll_seconds ? status.preroll_seconds + ' s' : 'off');
  showSound(status.recording && status.recording.sounds || []);
  showNotes(status);

  recording = !!status.recording;
  if (recording) setState('recording', 'Recording ' + clock(status.recording.seconds));
  else if (up < status.cameras.length) setState('trouble', 'Camera trouble');
  else setState('live', 'Live');
  const button = $('record');
  button.disabled = false;
  button.setAttribute('aria-pressed', String(recording));
  put($('record-text'), recording ? 'Stop' : 'Record');
  $('label').disabled = recording;

  const take = recording ? status.recording.take : null;
  if (take !== lastTake) {
    lastTake = take;
    readTakes();
  }
}

function span(className, text) {
  const element = document.createElement('span');
  element.className = className;
  element.textContent = text;
  return element;
}

async function readTakes() {
  const response = await fetch('api/takes');
  if (!response.ok) return;
  const takes = await response.json();
  $('no-takes').hidden = takes.length > 0;
  $('takes').replaceChildren(...takes.map((take) => {
    const row = document.createElement('li');
    const current = take.name === lastTake;
    const verdict = current ? 'open' : take.complete ? take.verdict : 'open';
    const words = current ? 'recording' : !take.complete ? 'cut off' : take.verdict || 'no verdict';
    const mark = span('verdict', words);
    mark.dataset.verdict = verdict;
    row.append(span('name', take.name), span('figure', current ? '' : clock(take.seconds)),
               span('figure', current ? '' : bytes(take.bytes)), mark);
    return row;
  }));
}

async function command() {
  const button = $('record');
  button.disabled = true;
  const url = recording ? 'api/stop' : 'api/record?label=' + encodeURIComponent($('label').value.trim());
  try {
    const response = await fetch(url, { method: 'POST' });
    const answer = await response.json();
    commandError = response.ok ? '' : answer.error;
  } catch (error) {
    commandError = 'The node does not answer.';
  }
  // The next status enables the button again; the list is read when the take changes.
}

$('record-form').addEventListener('submit', (event) => {
  event.preventDefault();
  command();
});
document.addEventListener('keydown', (event) => {
  if (event.key.toLowerCase() !== 'r' || event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
  if (event.target.closest('input') || $('record').disabled) return;
  command();
});

async function showPicture(message) {
  const tile = tiles[new Uint8Array(message, 0, 1)[0]];
  if (!tile || document.hidden) return;
  const picture = await createImageBitmap(new Blob([new Uint8Array(message, 1)], { type: 'image/jpeg' }));
  if (tile.canvas.width !== picture.width || tile.canvas.height !== picture.height) {
    tile.canvas.width = picture.width;
    tile.canvas.height = picture.height;
  }
  tile.canvas.getContext('2d').drawImage(picture, 0, 0);
  picture.close();
}

function connect() {
  const socket = new WebSocket((location.protocol === 'https:' ? 'wss://' : 'ws://') + location.host + '/live');
  socket.binaryType = 'arraybuffer';
  socket.onmessage = (event) => {
    if (typeof event.data === 'string') show(JSON.parse(event.data));
    else showPicture(event.data).catch(() => {});
  };
  socket.onclose = () => {
    setState('away', 'No connection');
    $('record').disabled = true;
    setTimeout(connect, 1000);
  };
}

readTakes();
connect();
