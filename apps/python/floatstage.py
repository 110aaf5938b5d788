"""Reads Floatstage's takes: photographs, true times, calibration, mattes and meshes as NumPy arrays.

One file, Python 3.9 and NumPy; photographs are decoded by the `ffmpeg` program. It only reads.

    import floatstage
    take = floatstage.Take("2026-11-20T101500Z-dance")
    rgb = take.photograph("cam0", 12)            # (height, width, 3) uint8, or None for a gap
    alpha = take.matte("cam0", 12)               # (height, width) uint8, or None where there is none
    vertices, faces = take.mesh(12)              # metres, z up
    samples, rate = take.sound("mic")            # (samples, channels) int32 of the track's bits, a second
    pixels, in_front = take.camera("cam0").project(vertices)

Pixels have the corner of the picture at (0, 0), so the middle of the first is (0.5, 0.5); `Camera.opencv()`
gives the matrix for programs that put (0, 0) into the middle of the first pixel. docs/formats.md is the
definition of every file.
"""

import csv
import hashlib
import json
import os
import re
import subprocess
import zlib
from dataclasses import dataclass

import numpy as np

__all__ = ["Added", "BadTake", "Camera", "Row", "SoundTrack", "Stamp", "Take", "read_mesh", "read_png", "read_rig"]


class BadTake(Exception):
    """Something in a take is missing, damaged or of a version that this module does not know. Names the file."""


@dataclass(frozen=True)
class Row:
    """An expected picture of one camera: a line of <serial>.frames.csv. Times in nanoseconds."""

    sequence: int
    device_time_ns: "int | None"
    studio_time_ns: int
    exposure_ns: "int | None"
    status: str  # "ok", "corrupt" or "lost"
    media_index: "int | None"


@dataclass(frozen=True)
class SoundTrack:
    """A sound track of sound.json: samples as a device of this nominal rate counted them."""

    name: str
    rate: int
    channels: int
    bits: int
    source: str  # where it came from: "clip.mp4", "alsa:hw:0"


@dataclass(frozen=True)
class Stamp:
    """A line of <name>.sound.csv: sample number `sample` was taken at this time, on the clock of Row's times.

    A run is sound without a gap; times of another run may lie anywhere.
    """

    sample: int
    studio_time_ns: int
    run: int


@dataclass(frozen=True)
class Added:
    """What lies over the pictures of a camera that no lens has seen, pixels."""

    bars: tuple  # left, top, right, bottom
    overlays: tuple  # (x, y, width, height) of time stamps, names and logos


@dataclass(frozen=True)
class Camera:
    """A calibrated camera of rig.json. A world point X lies at rotation @ X + translation before it."""

    serial: str
    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    skew: float
    lens: dict
    rotation: np.ndarray  # 3x3
    translation: np.ndarray  # metres

    @property
    def center(self):
        """Where the camera stands, in world metres."""
        return -self.rotation.T @ self.translation

    def project(self, points):
        """World points (N, 3) to pixels (N, 2), through the lens, and which of them lie before the camera.

        Pixels of points that do not are NaN.
        """
        points = np.atleast_2d(np.asarray(points, dtype=np.float64))
        seen = points @ self.rotation.T + self.translation
        front = seen[:, 2] > 0
        with np.errstate(divide="ignore", invalid="ignore"):
            flat = np.where(front[:, None], seen[:, :2] / seen[:, 2:], np.nan)
        x, y = _distorted(self.lens, flat).T
        return np.stack([self.fx * x + self.skew * y + self.cx, self.fy * y + self.cy], axis=1), front

    def opencv(self):
        """(K, coefficients) as OpenCV takes them; of a fisheye lens the coefficients are those of cv2.fisheye."""
        k = np.array([[self.fx, self.skew, self.cx - 0.5], [0, self.fy, self.cy - 0.5], [0, 0, 1]])
        kind, lens = self.lens.get("type", "none"), self.lens
        if kind == "none":
            return k, np.zeros(5)
        if kind == "kannala-brandt":
            return k, np.array([lens[f"k{i}"] for i in (1, 2, 3, 4)])
        names = ["k1", "k2", "p1", "p2", "k3"] + (["k4", "k5", "k6"] if "k4" in lens else [])
        return k, np.array([lens[name] for name in names])


def _distorted(lens, points):
    kind = lens.get("type", "none")
    if kind == "none":
        return points
    x, y = points.T
    r2 = x * x + y * y
    if kind == "kannala-brandt":
        r = np.sqrt(r2)
        a = np.arctan(r)
        b = a * a
        bent = a * (1 + b * (lens["k1"] + b * (lens["k2"] + b * (lens["k3"] + b * lens["k4"]))))
        scale = np.divide(bent, r, out=np.ones_like(r), where=r > 1e-12)
        return points * scale[:, None]
    top = 1 + r2 * (lens["k1"] + r2 * (lens["k2"] + r2 * lens["k3"]))
    bottom = 1 + r2 * (lens.get("k4", 0) + r2 * (lens.get("k5", 0) + r2 * lens.get("k6", 0)))
    radial, p1, p2 = top / bottom, lens["p1"], lens["p2"]
    return np.stack([x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                     y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y], axis=1)


def _bytes_of(path):
    try:
        with open(path, "rb") as file:
            return file.read()
    except OSError as error:
        raise BadTake(f"{path}: {error.strerror}") from None


def _load_json(path):
    try:
        return json.loads(_bytes_of(path))
    except ValueError as error:
        raise BadTake(f"{path} is not JSON: {error}") from None


def _rotation(wxyz):
    w, x, y, z = np.asarray(wxyz, dtype=np.float64) / np.linalg.norm(wxyz)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def _camera(c):
    pose = c["cam_from_world"]
    return Camera(c["serial"], c["width"], c["height"], c["fx"], c["fy"], c["cx"], c["cy"], c.get("skew", 0.0),
                  dict(c.get("lens", {"type": "none"})), _rotation(pose["rotation_wxyz"]),
                  np.array(pose["translation"], dtype=np.float64))


def read_rig(path):
    """The cameras of a rig.json, by serial, in its order."""
    rig = _load_json(path)
    try:
        if rig["floatstage_rig"] not in (1, 2, 3):
            raise BadTake(f"{path} is of format {rig['floatstage_rig']}; this module knows 1 to 3")
        return {c["serial"]: _camera(c) for c in rig["cameras"]}
    except (KeyError, TypeError, ValueError) as error:
        raise BadTake(f"{path} is no rig: {error!r}") from None


_PIXEL = {  # format: ffmpeg's name, and the shape of a picture of w x h
    "rgb8": ("rgb24", lambda w, h: (h, w, 3)),
    "gray8": ("gray", lambda w, h: (h, w)),
    "bayer-rggb8": ("gray", lambda w, h: (h, w)),
    "yuyv": ("rgb24", lambda w, h: (h, w, 3)),
    "nv12": ("rgb24", lambda w, h: (h, w, 3)),
}


class Take:
    """A recording. `cameras`: serials in the rig's order; `instants`: how many rows the longest side file has."""

    def __init__(self, folder):
        self.folder = os.fspath(folder)
        manifest = _load_json(self._path("take.json"))
        try:
            if manifest["floatstage_take"] != 1:
                raise BadTake(f"{self._path('take.json')} is of format {manifest['floatstage_take']}; "
                              "this module knows 1")
            self.label, self.frame_rate = manifest["label"], float(manifest["frame_rate"])
            self.complete = bool(manifest["complete"])
            self._media = {c["serial"]: c for c in manifest["cameras"]}
            wanted = manifest["rig_sha256"]
        except (KeyError, TypeError) as error:
            raise BadTake(f"{self._path('take.json')} is no take's manifest: {error!r}") from None
        self.rig = read_rig(self._path("rig.json"))
        if hashlib.sha256(_bytes_of(self._path("rig.json"))).hexdigest() != wanted:
            raise BadTake(f"{self._path('rig.json')} is not the rig of this take; its SHA-256 differs")
        self.cameras = [serial for serial in self.rig if serial in self._media]
        self._rows = {}

    def _path(self, *parts):
        return os.path.join(self.folder, *parts)

    def camera(self, serial):
        """The calibration of a camera."""
        try:
            return self.rig[serial]
        except KeyError:
            raise BadTake(f"{self.folder} has no camera {serial!r}; it has {', '.join(self.rig)}") from None

    def rows(self, serial):
        """The rows of a camera's side file, one an instant: what was expected, and what came."""
        self.camera(serial)
        if serial not in self._rows:
            self._rows[serial] = _read_rows(self._path(serial + ".frames.csv"))
        return self._rows[serial]

    @property
    def instants(self):
        return max((len(self.rows(serial)) for serial in self.cameras), default=0)

    def photograph(self, serial, frame):
        """The picture of a camera at an instant, or None where it is lost, damaged or beyond the end.

        RGB (height, width, 3); grey and Bayer (RGGB) pictures as they were recorded, (height, width). FFV1 and
        raw pictures of those formats are exact. YUYV and NV12 are converted by ffmpeg, H.264 is lossy. They are
        as recorded: Floatstage itself works on them without what `added()` names.
        """
        rows = self.rows(serial)
        row = rows[frame] if 0 <= frame < len(rows) else None
        if row is None or row.status != "ok" or row.media_index is None:
            return None
        return next(self._decoded(serial, row.media_index, 1))

    def photographs(self, serial, first=0, last=None):
        """(frame, picture or None) for all instants of a camera from `first` to before `last`: decoded in one go."""
        rows = self.rows(serial)[first:last]
        wanted = [row.media_index for row in rows if row.status == "ok" and row.media_index is not None]
        pictures = self._decoded(serial, wanted[0], wanted[-1] - wanted[0] + 1) if wanted else iter(())
        at = wanted[0] if wanted else 0
        for k, row in enumerate(rows):
            picture = None
            if row.status == "ok" and row.media_index is not None:
                while at <= row.media_index:
                    picture = next(pictures)
                    at += 1
            yield first + k, picture

    def added(self, serial):
        """The bars, stamps and logos that Floatstage found on a camera's pictures and hides, or None."""
        self.camera(serial)
        path = self._path("added.json")
        if not os.path.exists(path):
            return None
        record = _load_json(path)
        try:
            if record["floatstage_added"] != 1:
                raise BadTake(f"{path} is of format {record['floatstage_added']}; this module knows 1")
            if not record["hidden"]:
                return None
            for camera in record["cameras"]:
                if camera["serial"] == serial:
                    return Added(tuple(camera["bars"]), tuple(tuple(box) for box in camera["overlays"]))
        except (KeyError, TypeError) as error:
            raise BadTake(f"{path} is no record of what was added: {error!r}") from None
        return None

    @property
    def sounds(self):
        """The take's sound tracks, by name."""
        path = self._path("sound.json")
        if not os.path.exists(path):
            return {}
        record = _load_json(path)
        try:
            if record["floatstage_sound"] != 1:
                raise BadTake(f"{path} is of format {record['floatstage_sound']}; this module knows 1")
            return {t["name"]: SoundTrack(t["name"], t["rate"], t["channels"], t["bits"], t["from"])
                    for t in record["tracks"]}
        except (KeyError, TypeError) as error:
            raise BadTake(f"{path} is no list of sound tracks: {error!r}") from None

    def _track(self, name):
        tracks = self.sounds
        if name not in tracks:
            raise BadTake(f"{self.folder} has no sound track {name!r}; it has {', '.join(tracks) or 'none'}")
        return tracks[name]

    def sound(self, name):
        """(samples (N, channels) int32, rate) of a track, exactly as recorded; -2^(bits-1) to 2^(bits-1) - 1.

        `stamps()` says when they were taken: the device's clock is not the pictures'.
        """
        track, path = self._track(name), self._path(name + ".mka")
        data = _output_of(["ffmpeg", "-v", "error", "-nostdin", "-i", "file:" + path, "-map", "0:a:0", "-f", "s32le",
                           "-"], path)
        samples = np.frombuffer(data, dtype="<i4")
        if len(samples) % track.channels:
            raise BadTake(f"{path} does not have the {track.channels} channels that sound.json says")
        # ffmpeg gives 32 bits, the recorded ones above.
        return samples.reshape(-1, track.channels) >> (32 - track.bits), track.rate

    def stamps(self, name):
        """When the samples of a track were taken: its side file's rows, in order."""
        self._track(name)
        return _read_table(self._path(name + ".sound.csv"), ["sample", "studio_time_ns", "run"],
                           lambda row: Stamp(*(int(word) for word in row)))

    def _decoded(self, serial, index, count):
        media = self._media[serial]
        name, width, height = media["media"], media["width"], media["height"]
        if media["format"] not in _PIXEL:
            raise BadTake(f"{self._path(name)}: pictures of the format {media['format']} are not read here")
        pixels, shape = _PIXEL[media["format"]]
        # Times in the container are index / rate, rounded to milliseconds.
        seek = max(0.0, (index - 0.5) / self.frame_rate) if self.frame_rate > 0 else 0.0
        command = ["ffmpeg", "-v", "error", "-nostdin", "-ss", f"{seek:.6f}", "-i", "file:" + self._path(name),
                   "-map", "0:v:0", "-fps_mode", "passthrough", "-frames:v", str(count), "-f", "rawvideo",
                   "-pix_fmt", pixels, "-"]
        try:
            child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        except FileNotFoundError:
            raise BadTake("photographs are decoded by the program ffmpeg, which is not installed") from None
        size = int(np.prod(shape(width, height)))
        try:
            for k in range(count):
                data = child.stdout.read(size)
                if len(data) != size:
                    said = child.stderr.read().decode(errors="replace").strip()
                    raise BadTake(f"{self._path(name)}: picture {index + k} cannot be read. {said}".rstrip())
                yield np.frombuffer(data, dtype=np.uint8).reshape(shape(width, height))
        finally:
            child.stdout.close()
            child.stderr.close()
            child.kill()
            child.wait()

    def matte(self, serial, frame):
        """Opacity of the subject at an instant, (height, width), 0 background to 255; None where there is none."""
        self.camera(serial)
        path = self._path("mattes", serial, f"{frame:06d}.png")
        return read_png(path) if os.path.exists(path) else None

    def mesh(self, frame):
        """(vertices (N, 3), faces (M, 3)) of the visual hull at an instant, metres; None where there is none."""
        path = self._path("meshes", f"{frame:06d}.ply")
        return read_mesh(path) if os.path.exists(path) else None


def _output_of(command, path):
    try:
        ended = subprocess.run(command, capture_output=True, check=False)
    except FileNotFoundError:
        raise BadTake(f"media are decoded by the program {command[0]}, which is not installed") from None
    if ended.returncode != 0:
        raise BadTake(f"{path} cannot be read. {ended.stderr.decode(errors='replace').strip()}".rstrip())
    return ended.stdout


def _read_table(path, header, row_of):
    data = _bytes_of(path)
    # A last line without its end was being written when the recorder stopped.
    lines = data[: data.rfind(b"\n") + 1].decode("ascii", errors="replace").splitlines()
    if not lines or lines[0].split(",") != header:
        raise BadTake(f"{path} does not begin with the columns {', '.join(header)}")
    rows = []
    for number, line in enumerate(csv.reader(lines[1:]), start=2):
        try:
            if len(line) != len(header):
                raise ValueError
            rows.append(row_of(line))
        except ValueError:
            raise BadTake(f"{path}, line {number} is no row of a side file: {','.join(line)}") from None
    return rows


def _read_row(row):
    sequence, device, studio, exposure, status, index = row
    return Row(int(sequence), int(device) if device else None, int(studio), int(exposure) if exposure else None,
               status, int(index) if index else None)


def _read_rows(path):
    return _read_table(path, ["sequence", "device_time_ns", "studio_time_ns", "exposure_ns", "status", "media_index"],
                       _read_row)


def read_png(path):
    """An 8-bit PNG without interlacing: (height, width) of a grey one, else (height, width, channels)."""
    data = _bytes_of(path)
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise BadTake(f"{path} is no PNG")
    at, packed, head = 8, b"", None
    while at + 12 <= len(data):
        size, kind = int.from_bytes(data[at:at + 4], "big"), data[at + 4:at + 8]
        body = data[at + 8:at + 8 + size]
        if len(body) < size or zlib.crc32(kind + body) != int.from_bytes(data[at + 8 + size:at + 12 + size], "big"):
            raise BadTake(f"{path} is damaged: the part {kind.decode(errors='replace')} is cut or changed")
        if kind == b"IHDR":
            head = body
        elif kind == b"IDAT":
            packed += body
        at += 12 + size
    channels = {0: 1, 2: 3, 4: 2, 6: 4}.get(head[9]) if head else None
    if channels is None or head[8] != 8 or head[12] != 0:
        raise BadTake(f"{path} is not an 8-bit PNG of grey or colours without interlacing")
    width, height = int.from_bytes(head[:4], "big"), int.from_bytes(head[4:8], "big")
    try:
        raw = np.frombuffer(zlib.decompress(packed), dtype=np.uint8)
    except zlib.error as error:
        raise BadTake(f"{path} is damaged: {error}") from None
    stride = width * channels
    if raw.size != height * (stride + 1):
        raise BadTake(f"{path} is damaged: {raw.size} bytes of pixels instead of {height * (stride + 1)}")
    raw = raw.reshape(height, stride + 1)
    out = np.zeros((height, stride), dtype=np.uint8)
    above = np.zeros(stride, dtype=np.uint8)
    for y in range(height):
        above = _unfiltered(int(raw[y, 0]), raw[y, 1:], above, channels, path)
        out[y] = above
    return out.reshape(height, width) if channels == 1 else out.reshape(height, width, channels)


def _unfiltered(kind, row, above, channels, path):
    if kind == 0:
        return row
    if kind == 1:  # each byte was taken from the pixel before
        return np.cumsum(row.reshape(-1, channels), axis=0, dtype=np.uint8).reshape(-1)
    if kind == 2:
        return row + above
    if kind not in (3, 4):
        raise BadTake(f"{path} is damaged: a row has the filter {kind}")
    out, up, source = [0] * channels + [0] * len(row), [0] * channels + above.tolist(), row.tolist()
    for i, value in enumerate(source):
        a, b, c = out[i], up[i + channels], up[i]
        if kind == 3:
            guess = (a + b) // 2
        else:
            pa, pb, pc = abs(b - c), abs(a - c), abs(a + b - 2 * c)
            guess = a if pa <= pb and pa <= pc else b if pb <= pc else c
        out[i + channels] = (value + guess) & 255
    return np.array(out[channels:], dtype=np.uint8)


_PLY_TYPES = {"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
              "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
              "float": "f4", "float32": "f4", "double": "f8", "float64": "f8"}


def read_mesh(path):
    """(vertices (N, 3) float64, faces (M, 3) int32) of a binary little-endian PLY of triangles."""
    data = _bytes_of(path)
    end = re.search(rb"end_header\r?\n", data)
    if not data.startswith(b"ply") or not end or b"binary_little_endian" not in data[:end.start()]:
        raise BadTake(f"{path} is no binary little-endian PLY")
    elements = []
    for line in data[:end.start()].decode("ascii", errors="replace").splitlines():
        words = line.split()
        if words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"] and elements:
            elements[-1][2].append(words[1:])
    at, vertices, faces = end.end(), np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32)
    try:
        for name, count, properties in elements:
            if all(p[0] != "list" for p in properties):
                kind = np.dtype([(p[1], "<" + _PLY_TYPES[p[0]]) for p in properties])
            elif len(properties) == 1:
                kind = np.dtype([("n", "<" + _PLY_TYPES[properties[0][1]]),
                                 ("v", "<" + _PLY_TYPES[properties[0][2]], (3,))])
            else:
                raise BadTake(f"{path}: faces with other properties than their vertices are not read here")
            table = np.frombuffer(data, dtype=kind, count=count, offset=at)
            at += kind.itemsize * count
            if name == "vertex":
                vertices = np.stack([table[c].astype(np.float64) for c in "xyz"], axis=1)
            elif name == "face":
                if np.any(table["n"] != 3):
                    raise BadTake(f"{path} has faces that are no triangles")
                faces = table["v"].astype(np.int32)
    except (KeyError, ValueError) as error:
        raise BadTake(f"{path} is damaged or of another kind: {error}") from None
    return vertices, faces
