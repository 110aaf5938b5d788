#include "tests/recon/real_sets.h"

#include <algorithm>
#include <fstream>
#include <stdexcept>
#include <utility>

#include "calib/formats/format_files.h"
#include "core/png.h"
#include "core/text.h"

namespace floatstage::recon {
namespace {

template <class T>
T need(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

Image thresholded(const Image& image, int above) {
  Image mask(image.width, image.height, 1);
  for (std::size_t i = 0; i < mask.pixels.size(); ++i) {
    int sum = 0;
    const std::size_t channels = static_cast<std::size_t>(image.channels);
    for (std::size_t c = 0; c < channels; ++c) sum += image.pixels[i * channels + c];
    mask.pixels[i] = sum > above * image.channels ? 255 : 0;
  }
  return mask;
}

// Largest (dilation) or smallest (erosion) value in a square around each pixel, one axis after the other.
Image spread(const Image& in, int radius, bool grow) {
  Image rows = in, out = in;
  for (int pass = 0; pass < 2; ++pass) {
    const Image& from = pass ? rows : in;
    Image& to = pass ? out : rows;
    for (int y = 0; y < in.height; ++y)
      for (int x = 0; x < in.width; ++x)
        for (int d = -radius; d <= radius; ++d) {
          const int u = std::clamp(x + (pass ? 0 : d), 0, in.width - 1),
                    v = std::clamp(y + (pass ? d : 0), 0, in.height - 1);
          *to.at(x, y) =
              grow ? std::max(*to.at(x, y), *from.at(u, v)) : std::min(*to.at(x, y), *from.at(u, v));
        }
  }
  return out;
}

Image largest_component(const Image& mask) {
  std::vector<int> label(mask.pixels.size(), 0);
  int labels = 0, best = 0;
  std::size_t best_size = 0;
  for (std::size_t seed = 0; seed < label.size(); ++seed) {
    if (!mask.pixels[seed] || label[seed]) continue;
    std::vector<std::size_t> queue = {seed};
    label[seed] = ++labels;
    for (std::size_t next = 0; next < queue.size(); ++next) {
      const int x = static_cast<int>(queue[next]) % mask.width,
                y = static_cast<int>(queue[next]) / mask.width;
      for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        if (x + dx < 0 || y + dy < 0 || x + dx >= mask.width || y + dy >= mask.height) continue;
        const std::size_t other = mask.offset(x + dx, y + dy);
        if (!mask.pixels[other] || label[other]) continue;
        label[other] = labels;
        queue.push_back(other);
      }
    }
    if (queue.size() > best_size) {
      best_size = queue.size();
      best = labels;
    }
  }
  Image out = mask;
  for (std::size_t i = 0; i < label.size(); ++i) out.pixels[i] = label[i] == best ? 255 : 0;
  return out;
}

MatteSet load_temple(const std::filesystem::path& folder, const std::string& calibration, int grey) {
  const calib::ForeignRig foreign = need(calib::read_middlebury(folder / calibration));
  MatteSet set;
  for (std::size_t i = 0; i < foreign.rig.cameras.size(); ++i) {
    if (!std::filesystem::exists(folder / foreign.image_names[i])) continue;
    const Image image = need(load_png(folder / foreign.image_names[i]));
    RigCamera camera = foreign.rig.cameras[i];
    camera.model.width = image.width;
    camera.model.height = image.height;
    set.rig.cameras.push_back(camera);
    const Image mask = spread(spread(thresholded(image, grey), 2, true), 2, false);
    set.mattes.push_back(make_matte({}, largest_component(mask)));
  }
  return set;
}

}  // namespace

MatteSet load_temple_ring(const std::filesystem::path& folder, int grey) {
  return load_temple(folder, "templeR_par.txt", grey);
}

MatteSet load_temple_sparse_ring(const std::filesystem::path& folder) {
  return load_temple(folder, "templeSR_par.txt", 12);
}

MatteSet load_green_dome(const std::filesystem::path& folder) {
  MatteSet set;
  set.rig = need(calib::read_dome(folder / "calibration.txt", 0.1)).rig;
  for (RigCamera& camera : set.rig.cameras) {
    const Image mask = thresholded(need(load_png(folder / "mattes" / (camera.serial + ".png"))), 127);
    camera.model.width = mask.width;
    camera.model.height = mask.height;
    set.mattes.push_back(make_matte({}, mask));
  }
  return set;
}

MatteSet load_basketball(const std::filesystem::path& folder, const std::string& frame) {
  MatteSet set;
  set.rig = need(calib::read_dome(folder / "calibration.txt", 1)).rig;
  for (RigCamera& camera : set.rig.cameras) {
    camera.model.width = 640;
    camera.model.height = 360;
    const std::filesystem::path file = folder / "masks" / camera.serial / (frame + ".png");
    set.mattes.emplace_back();
    if (std::filesystem::exists(file))
      set.mattes.back() = make_matte({}, thresholded(need(load_png(file)), 127));
  }
  return set;
}

MatteSet load_vacancy_bunny(const std::filesystem::path& folder) {
  MatteSet set;
  std::ifstream poses(folder / "tumpose.txt");
  std::string index;
  Eigen::Vector3d t;
  Eigen::Quaterniond q;
  while (poses >> index >> t.x() >> t.y() >> t.z() >> q.x() >> q.y() >> q.z() >> q.w()) {
    const Image mask = thresholded(need(load_png(folder / ("mask_" + index + ".png"))), 127);
    RigCamera camera;
    camera.serial = index;
    // Its principal point counts from the first pixel's centre: so its own truth mesh fits its masks.
    camera.model = {.width = mask.width,
                    .height = mask.height,
                    .fx = 258.65,
                    .fy = 258.25,
                    .cx = 159.3 + 0.5,
                    .cy = 127.65 + 0.5,
                    .skew = 0,
                    .lens = {}};
    camera.cam_from_world = Rigid3{q.normalized(), t}.inverse();
    set.rig.cameras.push_back(camera);
    set.mattes.push_back(make_matte({}, mask));
  }
  if (set.mattes.size() != 6)
    throw std::runtime_error(text(folder.string(), ": ", set.mattes.size(), " poses, not 6"));
  return set;
}

MatteSet subset(const MatteSet& set, const std::vector<int>& cameras) {
  MatteSet part;
  for (int i : cameras) {
    part.rig.cameras.push_back(set.rig.cameras[static_cast<std::size_t>(i)]);
    part.mattes.push_back(set.mattes[static_cast<std::size_t>(i)]);
  }
  return part;
}

}  // namespace floatstage::recon
