#pragma once

#include <gtest/gtest.h>

#include "core/matte_edits.h"
#include "core/take_layout.h"
#include "pipeline/synthesize.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage {

/// A synthetic take of two performers who walk past one another, 200x150. In camera "cam00" the first one
/// hides the second in frame 12. Their true mattes together are a guide: truth().mattes().
inline std::filesystem::path crossing_take(const TempFolder& folder, int frames = 18) {
  pipeline::SynthesizeOptions options;
  options.out = folder / "take";
  options.rig = {.cameras = 2, .width = 200, .height = 150};
  options.studio.samples = 4;
  options.studio.frame_rate = 12.5;
  options.studio.cast = SyntheticCast::Two;
  options.studio.stage = SyntheticStage::Room;
  options.frames = frames;
  EXPECT_THAT(pipeline::synthesize_take(options), IsOk());
  return options.out;
}

/// In frame 0 of that camera the second performer is none of the subject.
inline MatteStroke off_the_second() {
  return {MatteLabel::Background, 2, {{70, 50}, {72, 65}, {70, 80}, {76, 95}, {74, 107}}};
}

}  // namespace floatstage
