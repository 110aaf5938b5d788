// The page: a camera that walks around the subject by mouse, touch and keys, and a time line.
"use strict";

(() => {
  const take = floatstageTake, $ = (id) => document.getElementById(id);
  const canvas = $("stage"), kMostPixels = 2.2e6, kAhead = 3, kMostLag = 250;
  // A picture that takes longer (ms) comes too late for its sound: the next ones have half of the pixels. After so many quick
  // ones in a row more are tried, later each time that this was too many.
  const kLate = 40, kQuick = 20, kRungs = 6, kCalm = 50;
  const orbit = { ...take.start };  // target, up, east, azimuth from there, elevation (radians), distance, fov_y
  const state = { frame: 0, playing: false, onPath: false, began: 0, shown: -1, wanted: true };
  const pace = { chosen: 0, whole: 0, lag: 0, rung: 0, late: 0, calm: 0, patience: kCalm, tried: false };  // of playing
  let renderer, frames, listen;

  function say(words) { $("message").textContent = words; $("message").hidden = words === ""; }
  function failed(error) { console.error(error); say(error.message); stop(); }

  function orbitKey() {
    const { target, up, east, azimuth, elevation, distance, fov_y } = orbit;
    const north = vec.cross(up, east), level = vec.add(vec.mul(east, Math.cos(azimuth)), vec.mul(north, Math.sin(azimuth)));
    const away = vec.add(vec.mul(level, Math.cos(elevation)), vec.mul(up, Math.sin(elevation))), eye = vec.add(target, vec.mul(away, distance));
    // A tall window shows as much from side to side as a wide one does from top to bottom.
    const aspect = canvas.width / canvas.height;
    const fov = aspect >= 0.75 ? fov_y : 2 * Math.atan(Math.tan(fov_y * Math.PI / 360) * 0.75 / aspect) * 180 / Math.PI;
    return { eye, target, up, fov_y: fov };
  }

  // Between two of the path's cameras; the frame is the earlier one's.
  function pathKey(seconds) {
    const last = take.path.length - 1, at = Math.min(last, Math.max(0, seconds * take.path_rate + 1e-6));
    const i = Math.floor(at), a = take.path[i], b = take.path[Math.min(i + 1, last)], share = at - i;
    const mix = (name) => vec.add(vec.mul(a[name], 1 - share), vec.mul(b[name], share));
    return { eye: mix("eye"), target: mix("target"), up: mix("up"), fov_y: a.fov_y + share * (b.fov_y - a.fov_y), frame: a.frame };
  }

  function fit() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    let width = canvas.clientWidth * ratio, height = canvas.clientHeight * ratio;
    const over = Math.sqrt(Math.max(1, width * height / kMostPixels) * (state.playing ? 2 ** pace.rung : 1));
    width = Math.max(1, Math.round(width / over));
    height = Math.max(1, Math.round(height / over));
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  }

  async function bring(frame) {
    const instant = await frames.get(frame);
    if (state.shown !== frame) renderer.show(instant);
    state.shown = frame;
    say("");
  }

  function draw(key) { renderer.draw(key, take.blend, take.background); }

  function stop() {
    listen?.stop();
    state.playing = state.onPath = false;
    for (const id of ["play", "path"]) $(id).setAttribute("aria-pressed", "false");
    $("play").textContent = "Play";
    state.wanted = true;
  }

  function start(onPath) {
    state.playing = true;
    state.onPath = onPath;
    const first = onPath ? 0 : state.frame / take.frame_rate;
    state.began = performance.now() - 1000 * first;
    if (!onPath) listen.start(first);
    pace.rung = 0;
    Object.assign(pace, { rung: rungsFor(pace.whole), lag: Math.min(pace.whole, kLate), late: -1, calm: 0, chosen: 0 });
    $(onPath ? "path" : "play").setAttribute("aria-pressed", "true");
    $("play").textContent = "Pause";
  }

  function setFrame(frame) {
    state.frame = frame;
    $("time").value = frame;
    $("clock").textContent = `${(frame / (take.frame_rate || 1)).toFixed(1)} s`;
    state.wanted = true;
  }

  // Seconds of playing now. The sound leads while it is heard: an ear minds a jump, an eye hardly does. At the end both
  // begin again.
  function playedFor() {
    const heard = state.onPath ? null : listen.position, now = performance.now();
    if (heard !== null) state.began = now - 1000 * heard;
    const seconds = (now - state.began) / 1000;
    if (state.onPath || seconds * take.frame_rate < take.frames.length) return seconds;
    state.began = now;
    listen.start(0);
    return 0;
  }

  // A picture is seen when it is drawn, so it is chosen for then: as long after the choice as the last ones took.
  function chosenFor(seconds) {
    pace.chosen = performance.now();
    return Math.min(seconds + pace.lag / 1000, (take.frames.length - 0.5) / take.frame_rate);
  }

  const rungsFor = (took) => Math.min(kRungs - pace.rung, Math.max(0, Math.ceil(Math.log2(took / kLate))));

  function drawn() {
    if (!pace.chosen) return;
    const took = Math.min(kMostLag, performance.now() - pace.chosen);
    pace.chosen = 0;
    if (!state.playing) {
      if (pace.whole === 0) state.wanted = true;  // the first one made shaders and targets, the second tells
      pace.whole = took;
      return;
    }
    pace.lag += 0.25 * (took - pace.lag);
    pace.late = took > kLate ? pace.late + 1 : 0;
    pace.calm = took < kQuick ? pace.calm + 1 : 0;
    if (pace.late >= 2 && pace.rung < kRungs) {
      if (pace.tried) pace.patience *= 2;
      Object.assign(pace, { rung: pace.rung + rungsFor(took), late: -1, calm: 0, tried: false });  // the next one makes new targets
    } else if (pace.calm >= pace.patience && pace.rung > 0) {
      Object.assign(pace, { rung: pace.rung - 1, late: -1, calm: 0, tried: true });
    }
  }

  let busy = false;
  async function tick() {
    requestAnimationFrame(tick);
    if (busy || !renderer.isDone) return;
    busy = true;
    try {
      drawn();
      const seconds = state.playing ? playedFor() : 0;
      if (state.playing) {
        const frame = state.onPath ? pathKey(seconds).frame : Math.floor(chosenFor(seconds) * take.frame_rate);
        if (frame !== state.frame) setFrame(frame);
        if (state.onPath) {
          state.wanted = true;
          if (seconds * take.path_rate >= take.path.length) stop();
        }
        for (let i = 1; i <= kAhead; ++i) {
          const later = state.onPath ? pathKey(seconds + i / take.frame_rate).frame : (state.frame + i) % take.frames.length;
          frames.get(later).catch(() => {});
        }
      }
      if (state.wanted) {
        state.wanted = false;
        const key = () => state.onPath ? pathKey(seconds) : orbitKey();
        if (!state.playing) pace.chosen = performance.now();
        await bring(state.frame);
        fit();
        draw(key());
      } else {
        pace.chosen = 0;
      }
    } catch (error) { failed(error); }
    busy = false;
  }

  function turn(dx, dy) {
    orbit.azimuth -= dx;
    orbit.elevation = Math.max(-1.5, Math.min(1.5, orbit.elevation + dy));
    if (state.onPath) stop();
    state.wanted = true;
  }
  function zoom(factor) {
    orbit.distance = Math.max(take.start.distance * 0.15, Math.min(take.start.distance * 6, orbit.distance * factor));
    if (state.onPath) stop();
    state.wanted = true;
  }

  // One finger or the mouse turns, two pinch.
  const fingers = new Map();
  const spread = () => { const [a, b] = [...fingers.values()]; return Math.hypot(a.x - b.x, a.y - b.y); };
  canvas.addEventListener("pointerdown", (e) => {
    canvas.setPointerCapture(e.pointerId);
    fingers.set(e.pointerId, { x: e.clientX, y: e.clientY });
  });
  canvas.addEventListener("pointermove", (e) => {
    const from = fingers.get(e.pointerId);
    if (!from) return;
    const before = fingers.size === 2 ? spread() : 0, dx = e.clientX - from.x, dy = e.clientY - from.y;
    from.x = e.clientX;
    from.y = e.clientY;
    const scale = Math.PI / Math.min(canvas.clientWidth, canvas.clientHeight);
    if (fingers.size === 1) turn(dx * scale, dy * scale);
    if (fingers.size === 2 && before > 0) zoom(before / Math.max(1, spread()));
  });
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (e) => fingers.delete(e.pointerId));
  canvas.addEventListener("wheel", (e) => { e.preventDefault(); zoom(Math.exp(0.001 * e.deltaY)); }, { passive: false });
  canvas.addEventListener("keydown", (e) => {
    const step = 0.06, keys = { ArrowLeft: () => turn(-step, 0), ArrowRight: () => turn(step, 0), ArrowUp: () => turn(0, step),
      ArrowDown: () => turn(0, -step), "+": () => zoom(0.9), "-": () => zoom(1 / 0.9), " ": () => $("play").click() };
    if (keys[e.key]) { e.preventDefault(); keys[e.key](); }
  });
  canvas.addEventListener("webglcontextlost", () => failed(new Error("The graphics processor was taken away; load the page again.")));
  $("play").addEventListener("click", () => state.playing ? stop() : start(false));
  $("path").addEventListener("click", () => state.onPath ? stop() : (stop(), start(true)));
  $("mute").addEventListener("click", () => {
    listen.muted = !listen.muted;
    $("mute").setAttribute("aria-pressed", String(listen.muted));
  });
  $("time").addEventListener("input", () => { stop(); setFrame(Number($("time").value)); });
  window.addEventListener("resize", () => { state.wanted = true; });

  // For tests and for pages around this one: a picture of the canvas, as a PNG's data URL.
  window.floatstage = {
    take,
    get shown() { return state.shown; },
    get azimuth() { return orbit.azimuth; },
    get key() { return orbitKey(); },  // where one stands, but for a path
    get pace() { return { ...pace }; },
    get heard() { return listen.position; },  // seconds; null while nothing is
    pathKey,
    async picture(frame, key, width, height) {
      while (busy) await new Promise((done) => setTimeout(done, 5));
      busy = true;
      try {
        stop();
        setFrame(frame);
        await bring(frame);
        Object.assign(canvas, { width, height });
        draw(key);
        return canvas.toDataURL("image/png");
      } finally { busy = false; }
    },
  };

  try {
    if (take.title) document.title = take.title;
    take.cameras.forEach((c) => { c.center = [...c.center]; });
    renderer = new Renderer(canvas, take.cameras);
    frames = new Frames(take);
    listen = new Listen(take.sound);
    listen.ready.then(() => {
      const mute = $("mute"), { element, trouble } = listen;
      mute.hidden = !element && trouble === "";
      if (trouble !== "") Object.assign(mute, { disabled: true, textContent: "No sound", title: trouble });
    });
    $("time").max = take.frames.length - 1;
    for (const id of ["play", "time", "clock"]) $(id).hidden = take.frames.length < 2;
    $("path").hidden = take.path.length === 0;
    setFrame(0);
    tick();
  } catch (error) { failed(error); }
})();
