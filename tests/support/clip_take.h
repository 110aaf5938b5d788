#pragma once

#include <gtest/gtest.h>

#include "capture/take.h"
#include "core/png.h"
#include "core/take_layout.h"
#include "tests/support/matchers.h"
#include "tests/support/matte_clips.h"
#include "tests/support/temp_folder.h"

namespace floatstage {

/// A camera without a lens in the middle of the world, of a picture's size.
inline RigCamera lone_camera(const std::string& serial, const Image& picture, double focal) {
  return {.serial = serial,
          .model = {.width = picture.width,
                    .height = picture.height,
                    .fx = focal,
                    .fy = focal,
                    .cx = picture.width / 2.0,
                    .cy = picture.height / 2.0,
                    .skew = 0,
                    .lens = {}},
          .cam_from_world = {},
          .color = {}};
}

/// A clip with exact truth as a take of one camera, "cam0"; the truth lies in truth/mattes.
inline std::filesystem::path clip_take(const TempFolder& folder, const MatteClip& clip,
                                       const std::string& name = "clip") {
  Rig rig;
  rig.cameras.push_back(lone_camera("cam0", clip.frames.front(), 300));
  const std::filesystem::path take = folder / name;
  auto writer = capture::TakeWriter::create(take, rig, {});
  EXPECT_THAT(writer, IsOk());
  for (std::size_t f = 0; f < clip.frames.size(); ++f) {
    FrameInfo info;
    info.camera = 0, info.sequence = f, info.exposure_start = {static_cast<std::int64_t>(f) * 40'000'000};
    EXPECT_THAT((*writer)->write(make_frame(info, clip.frames[f])), IsOk());
    const std::filesystem::path truth = TakeLayout(take / "truth").matte("cam0", static_cast<int>(f));
    std::filesystem::create_directories(truth.parent_path());
    EXPECT_THAT(save_png(clip.truth[f], truth), IsOk());
  }
  EXPECT_THAT((*writer)->finish(), IsOk());
  return take;
}

}  // namespace floatstage
