// Which photographs a view is drawn from, and how much each counts: choose_cameras() of render/camera_choice.cpp.
"use strict";

const kLeastFade = 1e-6, kAsNear = 1.75, kStandIns = 3, kMostListed = 6;

const vec = {
  sub: (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]],
  add: (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]],
  mul: (a, s) => [a[0] * s, a[1] * s, a[2] * s],
  dot: (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2],
  cross: (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]],
  length: (a) => Math.hypot(a[0], a[1], a[2]),
  normal: (a) => { const l = Math.hypot(a[0], a[1], a[2]); return [a[0] / l, a[1] / l, a[2] / l]; },
};

// A view: rotation rows (x right, y down, z forward), eye, focal length and middle in pixels of the canvas.
function viewOf(key, width, height) {
  const forward = vec.normal(vec.sub(key.target, key.eye));
  const right = vec.normal(vec.cross(forward, key.up)), down = vec.cross(forward, right);
  const f = 0.5 * height / Math.tan(0.5 * key.fov_y * Math.PI / 180);
  return { rows: [right, down, forward], eye: key.eye, f, cx: width / 2, cy: height / 2, width, height };
}

// 1 in the middle of the picture, falling smoothly outside it: what the view shows decides.
function importance(view, point) {
  const d = vec.sub(point, view.eye), z = vec.dot(view.rows[2], d);
  if (z <= 1e-3) return 1e-4;
  const x = (view.f * vec.dot(view.rows[0], d) / z + view.cx - 0.5 * view.width) / (0.5 * view.width);
  const y = (view.f * vec.dot(view.rows[1], d) / z + view.cy - 0.5 * view.height) / (0.5 * view.height);
  const r2 = x * x + y * y;
  return 1e-4 + 1 / (1 + r2 * r2);
}

// [{index, fade, standIn}], strongest first. `cameras` have a centre; `pictured` says which have a picture now.
function chooseCameras(cameras, samples, view, count, pictured) {
  const angle = cameras.map(() => 0);
  let total = 0;
  for (const p of samples) {
    const weight = importance(view, p), toView = vec.normal(vec.sub(view.eye, p));
    total += weight;
    cameras.forEach((c, i) => {
      const chord = vec.length(vec.sub(toView, vec.normal(vec.sub(c.center, p))));
      angle[i] += weight * 2 * Math.asin(Math.min(1, 0.5 * chord));
    });
  }
  if (total > 0) angle.forEach((a, i) => { angle[i] = a / total; });
  const order = cameras.map((c, i) => i).sort((a, b) => angle[a] - angle[b]);
  const usable = order.map((c, rank) => rank).filter((rank) => pictured[order[rank]]);
  const asked = Math.min(count, usable.length), most = Math.min(usable.length, 2 * count, kMostListed);
  const asNear = count > 1 && order.length > 0 ? kAsNear * angle[order[0]] : 0;
  let chosen = asked;
  while (chosen < most && angle[order[usable[chosen]]] < asNear) ++chosen;
  const listed = Math.min(usable.length, chosen + kStandIns, kMostListed);
  const endOfFade = (members) => {
    const rank = members === 0 ? 0 : usable[members - 1] + 1;
    return rank < order.length ? angle[order[rank]] : null;
  };
  const fade = (a, end) => end === null ? 1 : end > 0 ? Math.max(0, 1 - a / end) : 0;
  const listedEnd = endOfFade(listed), choice = [];
  let chosenEnd = endOfFade(chosen);
  if (chosen > asked) chosenEnd = Math.min(asNear, chosenEnd ?? asNear);
  for (let i = 0; i < listed; ++i) {
    const index = order[usable[i]];
    choice.push({ index, fade: i >= chosen ? 0 : fade(angle[index], chosenEnd), standIn: Math.max(kLeastFade, fade(angle[index], listedEnd)) });
  }
  return choice;
}
