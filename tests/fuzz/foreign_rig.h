#pragma once

#include <string_view>
#include <utility>

#include "calib/formats/parsers.h"
#include "core/check.h"

namespace floatstage {

/// What every reader of a foreign calibration promises: a rig that passes check() once its pictures' sizes
/// are known, apart from serials that cannot be file names.
inline void expect_sound(const Result<calib::ForeignRig>& foreign) {
  if (!foreign) return;
  FLOATSTAGE_CHECK(foreign->image_names.size() == foreign->rig.cameras.size(), "not one image name a camera");
  Rig rig = foreign->rig;
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    CameraModel& m = rig.cameras[i].model;
    if (m.width == 0) m.width = m.height = 1;
    FLOATSTAGE_CHECK(!rig.cameras[i].serial.empty(), "an empty serial");
  }
  const Result<void> sound = check(rig);
  FLOATSTAGE_CHECK(sound, "parsed, but " + sound.error().message);
}

/// The two files that one fuzzer's input holds.
inline std::pair<std::string_view, std::string_view> two_files(std::string_view input) {
  constexpr std::string_view kBetween = "\n===\n";
  const std::size_t at = input.find(kBetween);
  if (at == std::string_view::npos) return {input, {}};
  return {input.substr(0, at + 1), input.substr(at + kBetween.size())};
}

}  // namespace floatstage
