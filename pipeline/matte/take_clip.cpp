#include "pipeline/matte/take_clip.h"

#include "core/text.h"

namespace floatstage::pipeline {
namespace {

Result<Frame> nearest_photograph(capture::TakeReader& take, int camera, int frame) {
  for (int away = 0; away < take.frame_count(); ++away)
    for (const int f : {frame - away, frame + away}) {
      if (f < 0 || f >= take.frame_count()) continue;
      Result<Frame> photograph = take.frame(camera, f);
      if (!photograph || !photograph->empty()) return photograph;
    }
  return fail(ErrorCode::NotFound, "the camera has no photograph at all");
}

}  // namespace

matting::MattingClip clip_of(capture::TakeReader& take, int camera) {
  matting::MattingClip clip;
  clip.frames = take.frame_count();
  clip.photograph = [&take, camera](int frame) -> Result<Image> {
    Result<Frame> photograph = nearest_photograph(take, camera, frame);
    if (!photograph) return forward(photograph);
    return to_rgb(*photograph);
  };
  return clip;
}

matting::MatteConstraint opinion_of(const MatteKeyframe& keyframe, int width, int height) {
  matting::MatteConstraint opinion{Image(width, height, 1, 128), Image(width, height, 1)};
  paint_strokes(keyframe.strokes, 1, opinion.opacity);
  for (std::size_t p = 0; p < opinion.opacity.pixels.size(); ++p)
    opinion.weight.pixels[p] = opinion.opacity.pixels[p] == 128 ? 0 : 255;
  return opinion;
}

}  // namespace floatstage::pipeline
