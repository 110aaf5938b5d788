// The take's sound: AAC in base64 from a script, because a page from a file may load scripts and nothing else, and
// because a server that sends no parts of files would let nobody go back in one.
"use strict";

const kStuck = 2000;                // ms that a sound may stand still before pictures go on without it

let soundFile = null;
function soundLoaded(base64) { soundFile = base64; }

// What plays the sound, and tells what is heard now. Where there is none, or none that this browser plays, nothing is
// ever heard and nobody waits for it.
class Listen {
  constructor(source) {
    this.element = null;
    this.trouble = "";              // why nothing is heard of a take that has sound
    this.ready = source ? this.load(source).catch((error) => { console.error(error); this.trouble = error.message; }) : Promise.resolve();
  }

  async load(source) {
    await loadScript(source);
    const element = new Audio(URL.createObjectURL(new Blob([bytesOf(soundFile)], { type: "audio/mp4" })));
    soundFile = null;
    element.preload = "auto";
    await new Promise((done, failed) => {
      element.addEventListener("canplaythrough", done, { once: true });
      element.addEventListener("error", () => failed(new Error(`this browser cannot play the sound: ${element.error.message}`)), { once: true });
    });
    this.element = element;
  }

  // From a place on, in seconds. A browser that does not let it is as good as none.
  start(seconds) {
    if (!this.element) return;
    this.element.currentTime = seconds;
    Object.assign(this, { at: seconds, moved: performance.now() });
    this.element.play().catch((error) => { if (error.name !== "AbortError") console.error(error); });
  }
  stop() { this.element?.pause(); }
  set muted(is) { if (this.element) this.element.muted = is; }
  get muted() { return this.element?.muted ?? false; }

  // Seconds of the sound that are heard now, also while it is about to begin; null: none is.
  get position() {
    const element = this.element;
    if (!element || element.paused) return null;
    const at = element.currentTime, now = performance.now();
    if (at !== this.at) Object.assign(this, { at, moved: now });
    if (now - this.moved > kStuck) { element.pause(); return null; }
    return at;
  }
}
