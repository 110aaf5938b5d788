// The synthesis against the gates (../shared/data/detail/panda): 2048 x 2048 pixels from 128 x 128 and three
// children, as ADR 248 has it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "core/png.h"
#include "detail/synthesis/synthesis.h"
#include "tests/detail/synthesis_gates.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"
#include "tests/support/temp_folder.h"

namespace floatstage::detail::test {
namespace {

// One gate is not passed yet (ADR 250, 309, 310): how strong details are in windows of 64 px (0.40 is asked).
constexpr double kSubBandsReached = 0.5;

DetailLayer layer_of(const SynthesisProtocol& p, const Region& r) {
  const Image rgb = cut_out(p.truth, r);
  DetailLayer out{Image(rgb.width, rgb.height, 4, 255), r.x0, r.y0, 4, false};
  for (std::size_t i = 0; i < rgb.pixels.size() / 3; ++i)
    std::copy_n(&rgb.pixels[3 * i], 3, &out.picture.pixels[4 * i]);
  return out;
}

TEST(ASynthesisOfFur, PassesSixGatesAndComesNearTheOther) {
  FLOATSTAGE_NEEDS_DATA(real_data("detail/panda"));
  if (!wants_long_tests()) GTEST_SKIP() << "30 s; FLOATSTAGE_LONG=1 runs it";
  const Result<SynthesisProtocol> p = panda_protocol();
  ASSERT_THAT(p, IsOk());
  std::vector<DetailLayer> layers;
  for (const Region& r : p->children) layers.push_back(layer_of(*p, r));
  const Result<Synthesis> synthesis = Synthesis::make(p->low, layers, {});
  ASSERT_THAT(synthesis, IsOk());
  Image picture(2048, 2048, 3);
  Places places(2048UL * 2048, -1);
  parallel_for(64, 0, [&](std::size_t i) {
    const int x0 = static_cast<int>(i % 8) * 256, y0 = static_cast<int>(i / 8) * 256;
    const SynthesisTile tile = synthesis->tile({x0, y0, x0 + 256, y0 + 256});
    const Image part = to_picture(tile.colors);
    for (int y = 0; y < 256; ++y) {
      std::copy_n(part.at(0, y), 3 * 256, picture.at(x0, y0 + y));
      for (int x = 0; x < 256; ++x)
        if (const Exemplars::Place from = tile.places.at(x0 + x, y0 + y); from != Exemplars::kNowhere)
          places[static_cast<std::size_t>((y0 + y) * 2048 + x0 + x)] = from;
    }
  });
  const SynthesisFigures f = SynthesisJudge(*p).measure(picture, 256, places);
  RecordProperty("figures", to_text(f));
  EXPECT_THAT(failed_gates(f), testing::IsSubsetOf({"G3"})) << to_text(f);
  EXPECT_LT(f.sub_bands, kSubBandsReached) << to_text(f);
  for (const Region& r : p->children)  // inside the softened rim the real pixels
    EXPECT_EQ(cut_out(picture, {r.x0 + 8, r.y0 + 8, r.x1 - 8, r.y1 - 8}),
              cut_out(p->truth, {r.x0 + 8, r.y0 + 8, r.x1 - 8, r.y1 - 8}));
  if (const char* folder = std::getenv("FLOATSTAGE_PICTURES")) {
    EXPECT_THAT(save_png(picture, std::filesystem::path(folder) / "fur.png"), IsOk());
  }
}

}  // namespace
}  // namespace floatstage::detail::test
