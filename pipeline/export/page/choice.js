// Which photographs a view is drawn from, and how much each counts: choose_cameras() of render/camera_choice.cpp.
"use strict";

const kLeastFade = 1e-6, kAsNear = 1.75, kStandIns = 3, kMostListed = 6;
const kRim = 0.02, kFacing = 0.2, kShown = 0.02, kEnough = 0.3;

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

// How well a camera has a point in its picture: 1 inside, falling to 0 beyond the border.
function inPicture(camera, point) {
  const m = camera.matrix, row = (i) => m[i] * point[0] + m[4 + i] * point[1] + m[8 + i] * point[2] + m[12 + i];
  const z = row(2);
  if (z <= 0) return 0;
  const x = camera.fx * row(0) / z + camera.cx, y = camera.fy * row(1) / z + camera.cy;
  const within = Math.min(x, camera.width - x, y, camera.height - y);
  return Math.min(1, Math.max(0, 1 + within / (kRim * camera.width)));
}

// How well a camera sees a surface there, but for what stands before it: in its picture, and not from along it.
function shows(camera, point, normal) {
  const facing = vec.dot(normal, vec.normal(vec.sub(camera.center, point)));
  return inPicture(camera, point) * Math.min(1, Math.max(0, facing / kFacing));
}

// Of points with weights, how far each camera is from the view: the mean angle between the rays to both.
// `missing` says how much of each counts against a camera that does not show it.
function ranking(cameras, samples, view, weights, missing) {
  const angle = cameras.map(() => 0);
  let total = 0;
  samples.forEach(({ point: p, normal }, sample) => {
    const weight = weights[sample], penalty = missing ? missing[sample] : 0, toView = vec.normal(vec.sub(view.eye, p));
    total += weight;
    cameras.forEach((c, i) => {
      const chord = vec.length(vec.sub(toView, vec.normal(vec.sub(c.center, p))));
      angle[i] += weight * 2 * Math.asin(Math.min(1, 0.5 * chord));
      if (penalty > 0) angle[i] += penalty * Math.PI * (1 - shows(c, p, normal));
    });
  });
  if (total > 0) angle.forEach((a, i) => { angle[i] = a / total; });
  return { angle, order: cameras.map((c, i) => i).sort((a, b) => angle[a] - angle[b]) };
}

const fadeOf = (a, end) => end > 0 ? Math.max(0, 1 - a / end) : 0;

// [{index, fade, standIn}], strongest first. `cameras` are the page's; `pictured` says which have a picture now.
function chooseCameras(cameras, samples, view, count, pictured) {
  const weights = samples.map(({ point }) => importance(view, point));
  const nearest = ranking(cameras, samples, view, weights, null), { angle, order } = nearest;
  const usable = order.map((c, rank) => rank).filter((rank) => pictured[order[rank]]);
  const asked = Math.min(count, usable.length), most = Math.min(usable.length, 2 * count, kMostListed);
  const asNear = count > 1 && order.length > 0 ? kAsNear * angle[order[0]] : 0;
  let chosen = asked;
  while (chosen < most && angle[order[usable[chosen]]] < asNear) ++chosen;
  const next = chosen === 0 ? 0 : usable[chosen - 1] + 1;
  let chosenEnd = next < order.length ? angle[order[next]] : Infinity;
  if (chosen > asked) chosenEnd = Math.min(asNear, chosenEnd);
  const choice = [];
  for (let i = 0; i < chosen; ++i) {
    const index = order[usable[i]];
    choice.push({ index, fade: fadeOf(angle[index], chosenEnd) });
  }

  // Those that stand in: the next ones, or whoever has what lies beyond the pictures of the chosen ones.
  const fades = choice.map(({ fade }) => Math.max(kLeastFade, fade)), all = fades.reduce((sum, f) => sum + f, 0);
  const lacks = samples.map(({ point }, sample) => {
    const have = choice.reduce((sum, { index }, i) => sum + fades[i] * inPicture(cameras[index], point), 0);
    return weights[sample] * (1 - Math.min(1, have / (kEnough * all)));
  });
  const rest = lacks.some((lack) => lack > 0)
    ? ranking(cameras, samples, view, lacks.map((lack, sample) => lack + kShown * weights[sample]), lacks) : nearest;
  const listed = Math.min(chosen + kStandIns, kMostListed);
  let end = Infinity;
  for (const index of rest.order) {
    const isChosen = choice.slice(0, chosen).some((c) => c.index === index), room = choice.length < listed;
    if (isChosen) {
      if (room || chosen === listed) end = Infinity;
    } else if (room && pictured[index]) {
      choice.push({ index, fade: 0 });
      end = Infinity;
    } else {
      end = Math.min(end, rest.angle[index]);
    }
  }
  // Whoever has what is missing counts as much there as the chosen ones do elsewhere.
  const own = choice.map(({ index }) => Math.max(kLeastFade, fadeOf(rest.angle[index], end)));
  const strongest = rest === nearest ? 1 : Math.max(...own);
  choice.forEach((camera, i) => { camera.standIn = Math.max(camera.fade, own[i] / strongest); });
  return choice;
}
