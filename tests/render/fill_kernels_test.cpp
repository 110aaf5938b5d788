#include "render/fill_kernels.h"

#include <cstring>

#include <gtest/gtest.h>

#include "core/random.h"

namespace floatstage::render {
namespace {

constexpr std::size_t kLongest = 67;  // no multiple of any vector

struct Rows {
  std::vector<float> taken, pulled, weights, expanded, pushed;
};

std::vector<float> some(Random& random, std::size_t count, float most) {
  std::vector<float> out(count);
  for (float& v : out) v = most * static_cast<float>(random.next() % 1024) / 1024;
  return out;
}

Rows rows_by(const FillKernels& kernels, std::size_t count, std::size_t step) {
  Random random(7);
  const std::vector<float> values = some(random, 4 * count, 255), weight0 = some(random, 2 * count, 1),
                           weight1 = some(random, 2 * count, 1), value0 = some(random, 2 * count, 255),
                           value1 = some(random, 2 * count, 255);
  std::vector<std::uint8_t> known(count);
  for (std::uint8_t& k : known) k = random.next() % 3 ? 1 : 0;
  Rows rows{std::vector<float>(count), std::vector<float>(count), std::vector<float>(count),
            std::vector<float>(2 * count - 1), value1};
  kernels.take(values.data(), step, known.data(), count, rows.taken.data());
  kernels.pull(value0.data(), weight0.data(), value1.data(), weight1.data(), count, rows.pulled.data());
  kernels.pull_weights(weight0.data(), weight1.data(), count, rows.weights.data());
  kernels.expand(value0.data(), count, 2 * count - 1, rows.expanded.data());
  kernels.push(value0.data(), 0.25F, weight0.data(), 0.75F, weight1.data(), count, rows.pushed.data());
  return rows;
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

TEST(FillKernels, GiveTheSameBitsOnEveryInstructionSet) {
  const std::vector<FillKernels> all = all_fill_kernels();
  ASSERT_FALSE(all.empty());
  for (std::size_t count = 1; count <= kLongest; ++count)
    for (const std::size_t step : {1u, 2u, 3u, 4u}) {
      const Rows first = rows_by(all.front(), count, step);
      for (const FillKernels& kernels : all) {
        SCOPED_TRACE(testing::Message() << kernels.name << ", " << count << " pixels, step " << step);
        const Rows rows = rows_by(kernels, count, step);
        ASSERT_TRUE(same_bits(rows.taken, first.taken));
        ASSERT_TRUE(same_bits(rows.pulled, first.pulled));
        ASSERT_TRUE(same_bits(rows.weights, first.weights));
        ASSERT_TRUE(same_bits(rows.expanded, first.expanded));
        ASSERT_TRUE(same_bits(rows.pushed, first.pushed));
      }
    }
}

}  // namespace
}  // namespace floatstage::render
