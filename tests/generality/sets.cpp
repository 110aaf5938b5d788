#include "tests/generality/sets.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <utility>

#include "calib/rig_formats.h"
#include "capture/take.h"
#include "core/file.h"
#include "core/jpeg.h"
#include "core/png.h"
#include "core/synthetic/synthetic_studio.h"
#include "core/text.h"
#include "matting/keyers/keyer.h"
#include "matting/view_cut.h"
#include "tests/support/clip_take.h"
#include "tests/support/real_data.h"

namespace floatstage::generality {
namespace {

namespace fs = std::filesystem;

constexpr int kShortSide = 320;  // px, at most, in the short form

template <class T>
T need(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

void need(const Result<void>& result) {
  if (!result) throw std::runtime_error(result.error().message);
}

Image rgb_picture(const fs::path& file, int width, int height) {
  if (file.extension() == ".png") return need(load_png(file));
  const std::string bytes = need(read_file(file));
  return need(decode_jpeg(std::as_bytes(std::span(bytes)), width, height));
}

Image one_channel(const Image& picture) {
  Image grey(picture.width, picture.height, 1);
  for (std::size_t i = 0; i < grey.pixels.size(); ++i)
    grey.pixels[i] = picture.pixels[i * static_cast<std::size_t>(picture.channels)];
  return grey;
}

// The set as smaller cameras would have seen it.
void shrink(StageSet& set, bool full) {
  if (full) return;
  for (std::size_t i = 0; i < set.rig.cameras.size(); ++i) {
    CameraModel& m = set.rig.cameras[i].model;
    const double scale = static_cast<double>(kShortSide) / std::max(m.width, m.height);
    if (scale >= 1) continue;
    const int width = std::max(1, static_cast<int>(std::lround(scale * m.width))),
              height = std::max(1, static_cast<int>(std::lround(scale * m.height)));
    const double sx = static_cast<double>(width) / m.width, sy = static_cast<double>(height) / m.height;
    for (auto& frame : set.pictures) frame[i] = matting::shrunk(frame[i], width, height);
    if (!set.truth[i].empty())
      set.truth[i] = make_matte({}, matting::shrunk(to_image(set.truth[i]), width, height));
    m.width = width, m.height = height;
    m.fx *= sx, m.cx *= sx, m.skew *= sx, m.fy *= sy, m.cy *= sy;
  }
}

StageSet studio(SyntheticStage stage, bool full) {
  const SyntheticRigOptions ring{.width = full ? 640 : 320, .height = full ? 480 : 240};
  const SyntheticStudio shown = need(SyntheticStudio::create(
      synthetic_rig(ring), {.samples = full ? 9 : 4, .stage = stage, .defects = {.noise = 1}}));
  StageSet set;
  set.rig = shown.published_rig();
  set.pictures.resize(1);
  for (int i = 0; i < static_cast<int>(set.rig.cameras.size()); ++i) {
    const SyntheticShot shot = shown.shoot(i, 5);
    set.pictures[0].push_back(need(to_rgb(shot.frame)));
    set.truth.push_back(shot.matte);
    set.plates.push_back(shown.plate(i));
  }
  return set;
}

StageSet dome(const fs::path& folder, bool full) {
  StageSet set;
  set.rig = need(calib::read_rig({.format = "dome", .path = folder})).rig;
  set.pictures.resize(1);
  for (RigCamera& c : set.rig.cameras) {
    set.pictures[0].push_back(need(load_png(folder / "images" / (c.serial + ".png"))));
    set.truth.push_back(make_matte({}, one_channel(need(load_png(folder / "mattes" / (c.serial + ".png"))))));
    c.model.width = set.pictures[0].back().width;
    c.model.height = set.pictures[0].back().height;
  }
  shrink(set, full);
  return set;
}

// Cameras without masks are left out.
StageSet basketball(const fs::path& folder, bool full) {
  const Rig all = need(calib::read_rig({.format = "dome", .path = folder, .metres_per_unit = 1})).rig;
  StageSet set;
  set.pictures.resize(1);
  for (RigCamera c : all.cameras) {
    const fs::path mask = folder / "masks" / c.serial / "040.png";
    if (!fs::exists(mask)) continue;
    c.model.width = 640, c.model.height = 360;
    set.rig.cameras.push_back(c);
    set.pictures[0].push_back(rgb_picture(folder / "images" / c.serial / "040.jpg", 640, 360));
    set.truth.push_back(make_matte({}, one_channel(need(load_png(mask)))));
  }
  shrink(set, full);
  return set;
}

Matte brighter_than(const Image& picture, int grey) {
  const auto keyer = need(matting::make_keyer(
      text("luminance:", grey), {},
      matting::CleanupOptions{.close_radius = 2, .smallest_hole = 0.01, .largest_only = true}));
  return need(keyer->key(make_frame({}, picture)));
}

StageSet middlebury(const fs::path& folder, int grey, bool full) {
  const calib::ForeignRig foreign = need(calib::read_rig({.format = "middlebury", .path = folder}));
  StageSet set;
  set.pictures.resize(1);
  for (std::size_t i = 0; i < foreign.rig.cameras.size(); ++i) {
    if (!fs::exists(folder / foreign.image_names[i])) continue;
    const Image picture = need(load_png(folder / foreign.image_names[i]));
    RigCamera c = foreign.rig.cameras[i];
    c.model.width = picture.width, c.model.height = picture.height;
    set.rig.cameras.push_back(c);
    set.truth.push_back(brighter_than(picture, grey));
    set.pictures[0].push_back(picture);
  }
  shrink(set, full);
  return set;
}

// A hand-held camera in a street.
StageSet street(const fs::path& folder, bool full) {
  StageSet set;
  std::vector<fs::path> files;
  for (const fs::directory_entry& e : fs::directory_iterator(folder / "frames")) files.push_back(e.path());
  std::sort(files.begin(), files.end());
  for (std::size_t f = 0; f < std::min<std::size_t>(files.size(), 4); ++f)
    set.pictures.push_back({rgb_picture(files[f], 960, 540)});
  const Image woman = one_channel(need(load_png(folder / "mask_000_person1.png"))),
              man = one_channel(need(load_png(folder / "mask_000_person2.png")));
  Image both = woman;
  for (std::size_t i = 0; i < both.pixels.size(); ++i)
    both.pixels[i] = std::max(woman.pixels[i], man.pixels[i]) ? 255 : 0;
  set.truth.push_back(make_matte({}, both));
  set.rig.cameras.push_back(lone_camera("hand", set.pictures[0][0], 900));
  shrink(set, full);
  return set;
}

}  // namespace

std::vector<SetName> all_sets() {
  std::vector<SetName> sets;
  for (const SyntheticStageName& s : synthetic_stages())
    sets.push_back(
        {text("studio, ", s.name), {}, [stage = s.stage](bool full) { return studio(stage, full); }});
  const auto add = [&](const char* name, const std::function<StageSet(const fs::path&, bool)>& load) {
    sets.push_back(
        {name, real_data(name), [load, folder = real_data(name)](bool full) { return load(folder, full); }});
  };
  add("green-dome", dome);
  add("green-dome-wd", dome);
  add("middlebury-temple-ring", [](const fs::path& f, bool full) { return middlebury(f, 40, full); });
  add("middlebury-temple-sparse-ring", [](const fs::path& f, bool full) { return middlebury(f, 40, full); });
  add("middlebury-dino-sparse-ring", [](const fs::path& f, bool full) { return middlebury(f, 40, full); });
  add("dynamic-basketball", basketball);
  add("clip-two-persons", street);
  return sets;
}

void write_take(const StageSet& set, const fs::path& folder) {
  const auto writer = need(capture::TakeWriter::create(folder, set.rig, {}));
  for (std::size_t f = 0; f < set.pictures.size(); ++f)
    for (std::size_t i = 0; i < set.rig.cameras.size(); ++i) {
      FrameInfo info;
      info.camera = static_cast<int>(i), info.sequence = f;
      info.exposure_start = {static_cast<std::int64_t>(f) * 40'000'000};
      need(writer->write(make_frame(info, set.pictures[f][i])));
    }
  need(writer->finish());
  const TakeLayout layout(folder);
  for (std::size_t i = 0; i < set.plates.size(); ++i) {
    const fs::path plate = layout.plate(set.rig.cameras[i].serial);
    fs::create_directories(plate.parent_path());
    need(save_png(set.plates[i], plate));
  }
}

}  // namespace floatstage::generality
