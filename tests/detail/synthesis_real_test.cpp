// The synthesis against the gates (../shared/data/detail/panda).

#include <cstdlib>
#include <ctime>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "core/png.h"
#include "detail/synthesis/synthesis.h"
#include "tests/detail/synthesis_gates.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"

namespace floatstage::detail::test {
namespace {

DetailLayer layer_of(const SynthesisProtocol& p, const Region& r) {
  const Image rgb = cut_out(p.truth, r);
  DetailLayer out{Image(rgb.width, rgb.height, 4, 255), r.x0, r.y0, 4, false};
  for (std::size_t i = 0; i < rgb.pixels.size() / 3; ++i)
    std::copy_n(&rgb.pixels[3 * i], 3, &out.picture.pixels[4 * i]);
  return out;
}

TEST(ASynthesisOfFur, PassesTheGates) {
  FLOATSTAGE_NEEDS_DATA(real_data("detail/panda"));
  const Result<SynthesisProtocol> p = panda_protocol();
  ASSERT_THAT(p, IsOk());
  std::vector<DetailLayer> layers;
  for (const Region& r : p->children) layers.push_back(layer_of(*p, r));
  const SynthesisJudge judge(*p);
  {
    const int n = getenv("N") ? atoi(getenv("N")) : 2;
    SynthesisOptions options;
    options.iterations = n;
    std::clock_t t0 = std::clock();
    Result<Synthesis> s = Synthesis::make(p->low, layers, options);
    ASSERT_THAT(s, IsOk());
    std::clock_t t1 = std::clock();
    s->tile({256, 1536, 512, 1792});
    std::clock_t t2 = std::clock();
    const SynthesisTile tile = s->tile({0, 0, 2048, 2048});
    std::clock_t t3 = std::clock();
    const Image picture = to_picture(tile.colors);
    Places places(tile.places.values.size());
    for (std::size_t i = 0; i < places.size(); ++i)
      places[i] = tile.places.values[i] == Exemplars::kNowhere ? -1 : tile.places.values[i];
    const SynthesisFigures f = judge.measure(picture, 256, places);
    std::printf("%d: prep %.2f tile %.2f all %.2f %s\n", n, double(t1 - t0) / 1e6, double(t2 - t1) / 1e6,
                double(t3 - t2) / 1e6, to_text(f).c_str());
    std::fflush(stdout);
    ASSERT_THAT(save_png(picture, "/tmp/syn/out" + std::to_string(n) + ".png"), IsOk());
  }
}

}  // namespace
}  // namespace floatstage::detail::test
