#pragma once

#include <filesystem>
#include <functional>

#include <gtest/gtest.h>

#include "capture/take.h"
#include "core/image.h"
#include "tests/support/matchers.h"

namespace floatstage {

/// What a defective camera makes of a picture of its: camera, frame, picture.
using Defect = std::function<Image(int, int, Image)>;

/// The photographs and plates of `from` as new take `out`, after `defect`. Nothing derived comes along.
inline void rewrite_take(const std::filesystem::path& from, const std::filesystem::path& out,
                         const Defect& defect) {
  const auto take = capture::TakeReader::open(from);
  ASSERT_THAT(take, IsOk());
  const Rig& rig = (*take)->rig();
  capture::TakeWriterOptions options;
  options.frame_rate = (*take)->manifest().frame_rate;
  const auto writer = capture::TakeWriter::create(out, rig, options);
  ASSERT_THAT(writer, IsOk());
  for (int frame = 0; frame < (*take)->frame_count(); ++frame)
    for (int camera = 0; camera < static_cast<int>(rig.cameras.size()); ++camera) {
      const Frame photograph = (*take)->frame(camera, frame).value();
      const Image changed = defect(camera, frame, to_rgb(photograph).value());
      ASSERT_THAT((*writer)->write(make_frame(photograph.info, changed)), IsOk());
    }
  ASSERT_THAT((*writer)->finish(), IsOk());
  std::filesystem::copy(from / "plates", out / "plates", std::filesystem::copy_options::recursive);
}

}  // namespace floatstage
