#include "pipeline/camera_still.h"

#include <algorithm>
#include <cmath>

#include "core/text.h"
#include "matting/camera_motion.h"

namespace floatstage::pipeline {
namespace {

constexpr std::size_t kToCompare = 12;  // pictures, spread over all of them, with the first

}  // namespace

Result<void> check_still(const std::string& serial, const std::vector<Image>& pictures,
                         const std::vector<std::string>& names) {
  const std::size_t count = pictures.size(), step = std::max<std::size_t>(1, count / kToCompare);
  for (std::size_t i = step; i < count; i += step) {
    if (pictures[i].width != pictures[0].width || pictures[i].height != pictures[0].height) continue;
    const matting::CameraStillness seen = matting::stillness_between(pictures[0], pictures[i]);
    if (!seen.camera_moved()) continue;
    const double way = std::round(10 * seen.moved) / 10;
    return fail(
        ErrorCode::Unsupported,
        text("camera '", serial, "' moved: between ", names[0], " and ", names[i], " only ", seen.still,
             " of ", seen.textured,
             " parts of the picture stayed where they were, and "
             "the others went ",
             way,
             " px, so no plate or backdrop holds; use --matte spectral with clicks on the subject, give "
             "mattes with --guide, or record with the camera fixed"));
  }
  return {};
}

Result<void> check_camera_still(capture::TakeReader& take, int camera) {
  std::vector<Image> pictures;
  std::vector<std::string> names;
  const int count = take.frame_count(), wanted = std::min(static_cast<int>(kToCompare), count);
  for (int i = 0; i < wanted; ++i) {
    const int frame = wanted > 1 ? static_cast<int>(static_cast<long>(count - 1) * i / (wanted - 1)) : 0;
    Result<Frame> photograph = take.frame(camera, frame);
    if (!photograph) return forward(photograph);
    if (photograph->empty()) continue;
    Result<Image> rgb = to_rgb(*photograph);
    if (!rgb) return forward(rgb);
    pictures.push_back(std::move(*rgb));
    names.push_back(text("frame ", frame));
  }
  return check_still(take.rig().cameras[static_cast<std::size_t>(camera)].serial, pictures, names);
}

}  // namespace floatstage::pipeline
