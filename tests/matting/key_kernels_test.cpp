#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/random.h"
#include "matting/cut_kernels.h"
#include "matting/keyers/alpha_bits.h"
#include "matting/keyers/cloth_kernels.h"
#include "matting/keyers/field_kernels.h"

namespace floatstage::matting {
namespace {

std::vector<std::uint8_t> noise(std::size_t count, Random& random) {
  std::vector<std::uint8_t> bytes(count);
  for (std::uint8_t& v : bytes) v = static_cast<std::uint8_t>(random.uniform(0, 256));
  return bytes;
}

TEST(BitKernels, SayWhichBytesReachALevel) {
  Random random(2);
  const std::vector<std::uint8_t> bytes = noise(256, random);
  for (const BitKernels& kernels : all_bit_kernels())
    for (const int level : {1, 24, 128, 255}) {
      std::vector<std::uint64_t> bits(4);
      kernels.at_least(bytes.data(), 4, static_cast<std::uint8_t>(level), bits.data());
      for (std::size_t x = 0; x < bytes.size(); ++x)
        ASSERT_EQ(bits[x / 64] >> (x % 64) & 1, bytes[x] >= level) << kernels.name << ' ' << level;
    }
}

TEST(AlphaBits, AreThoseOfAnyPartOfAPicture) {
  Random random(3);
  for (const int width : {1, 63, 64, 65, 200}) {
    Image alpha(width, 9, 1);
    alpha.pixels = noise(alpha.pixels.size(), random);
    const BitBox box{width / 3, 2, width, 8};
    BitRows bits;
    bits_of(alpha, box, 77, bits);
    for (int y = box.y0; y < box.y1; ++y) {
      std::vector<std::uint8_t> set(static_cast<std::size_t>(bits.width()), 9), copied = set;
      set_row(bits.row(y - box.y0), bits.width(), 5, set.data());
      copy_row(bits.row(y - box.y0), bits.width(), alpha.at(box.x0, y), copied.data());
      std::vector<bool> seen(set.size(), false);
      for_each_bit(bits, y - box.y0, [&](int x) { seen[static_cast<std::size_t>(x)] = true; });
      for (int x = box.x0; x < box.x1; ++x) {
        const auto i = static_cast<std::size_t>(x - box.x0);
        const bool is = *alpha.at(x, y) >= 77;
        EXPECT_EQ(bits.at(x - box.x0, y - box.y0), is);
        EXPECT_EQ(seen[i], is);
        EXPECT_EQ(set[i], is ? 5 : 9);
        EXPECT_EQ(copied[i], is ? *alpha.at(x, y) : 9);
      }
    }
  }
}

TEST(AlphaBits, BoundWhatIsNotZero) {
  Image alpha(100, 50, 1);
  EXPECT_TRUE(bounding_box(alpha).empty());
  *alpha.at(70, 20) = 1;
  *alpha.at(30, 44) = 1;
  *alpha.at(50, 30) = 255;
  const BitBox box = bounding_box(alpha);
  EXPECT_EQ(box.x0, 30);
  EXPECT_EQ(box.x1, 71);
  EXPECT_EQ(box.y0, 20);
  EXPECT_EQ(box.y1, 45);
}

TEST(AlphaBits, GrowAndShrinkByMoreThanAWord) {
  BitMorphology morphology;
  BitRows bits, grown, back;
  bits.resize(500, 400);
  bits.clear();
  bits.set(200, 250, 251);
  dilate_square(morphology, bits, 150, grown);
  for (int y = 0; y < 400; ++y)
    for (int x = 0; x < 500; ++x)
      ASSERT_EQ(grown.at(x, y), std::abs(x - 250) <= 150 && std::abs(y - 200) <= 150) << x << ' ' << y;
  erode_square(morphology, grown, 150, back);
  EXPECT_TRUE(std::equal(back.all().begin(), back.all().end(), bits.all().begin()));
}

TEST(ClothKernels, GiveTheOpacityOfOnePixelAfterTheOther) {
  Random random(5);
  const std::size_t count = 192;
  const std::vector<std::uint8_t> r = noise(count, random), g = noise(count, random),
                                  b = noise(count, random);
  const ClothMeasure measure({40, 120, 60});
  for (const ClothKernels& kernels : all_cloth_kernels()) {
    std::vector<std::uint8_t> alpha(count), doubt(count);
    kernels.alphas(measure, r.data(), g.data(), b.data(), count, alpha.data(), doubt.data());
    for (std::size_t x = 0; x < count; ++x) {
      const float value = measure.value(r[x], g[x], b[x]);
      ASSERT_EQ(alpha[x], static_cast<int>(std::clamp(value, 0.0f, 255.0f))) << kernels.name;
      ASSERT_EQ(doubt[x], value > measure.doubtful ? 255 : 0) << kernels.name;
    }
  }
}

TEST(CutKernels, GiveSquaredDifferencesAndTheirSums) {
  Random random(6);
  const std::size_t count = 77, room = count + 16;
  std::vector<std::uint8_t> planes[6], asked[2];
  for (std::vector<std::uint8_t>& plane : planes) plane = noise(room, random);
  for (std::vector<std::uint8_t>& is : asked) {
    is = noise(room, random);
    for (std::uint8_t& v : is) v &= 1;
  }
  const std::uint8_t *a[] = {planes[0].data(), planes[1].data(), planes[2].data()},
                     *b[] = {planes[3].data(), planes[4].data(), planes[5].data()};
  std::vector<std::uint32_t> expected;
  CutKernels::Contrast sum;
  for (std::size_t x = 0; x < count; ++x) {
    std::uint32_t d = 0;
    for (int k = 0; k < 3; ++k) d += static_cast<std::uint32_t>((a[k][x] - b[k][x]) * (a[k][x] - b[k][x]));
    expected.push_back(std::min(d, 30000U));
    if (!asked[0][x] && !asked[1][x]) continue;
    sum.sum += d, sum.pairs += 1, sum.most = std::max(sum.most, d);
  }
  for (const CutKernels& kernels : all_cut_kernels()) {
    std::vector<std::uint32_t> found(room);
    kernels.differences(a, b, count, 30000, found.data());
    found.resize(count);
    EXPECT_EQ(found, expected) << kernels.name;
    CutKernels::Contrast all;
    kernels.add(a, b, asked[0].data(), asked[1].data(), count, all);
    EXPECT_EQ(all.sum, sum.sum) << kernels.name;
    EXPECT_EQ(all.pairs, sum.pairs) << kernels.name;
    EXPECT_EQ(all.most, sum.most) << kernels.name;
  }
}

TEST(FieldKernels, GiveTheSameBitsOnEveryInstructionSet) {
  Random random(7);
  const std::size_t cells = 20, stride = 64, count = 128;
  std::vector<float> terms(FieldRow::kTerms * stride), known(stride, 1), between(stride);
  for (float& t : terms) t = static_cast<float>(random.uniform(-1, 3));
  for (std::size_t k = 0; k < 3 * stride; ++k) terms[k] = static_cast<float>(random.uniform(0, 255));
  known[7] = known[12] = 0;
  std::vector<std::uint8_t> planes[3];
  std::vector<std::uint32_t> columns[3];
  for (int k = 0; k < 3; ++k) {
    planes[k] = noise(count, random);
    for (std::size_t i = 0; i < count + 8; ++i)
      columns[k].push_back(static_cast<std::uint32_t>(random.uniform(0, 1275)));
  }
  const std::uint8_t* rgb[] = {planes[0].data(), planes[1].data(), planes[2].data()};
  const FieldMeans means{{columns[0].data(), columns[1].data(), columns[2].data()}, 5};
  for (const bool narrow : {false, true})
    for (const bool darker : {false, true}) {
      std::vector<std::int32_t> left(count);
      std::vector<float> shares(count);
      for (std::size_t x = 0; x < count; ++x) {
        const double at =
            (narrow ? static_cast<double>((x * 7) % cells) : static_cast<double>(x * cells) / count);
        left[x] = static_cast<std::int32_t>(at);
        shares[x] = static_cast<float>(narrow ? random.uniform() : at - left[x]);
      }
      const FieldRow row{terms.data(), stride, known.data(), left.data(), shares.data(), narrow, darker};
      std::vector<std::vector<float>> distances;
      std::vector<std::vector<std::uint8_t>> alphas;
      for (const FieldKernels& kernels : all_field_kernels()) {
        auto& d = distances.emplace_back(count);
        kernels.distances(row, means, count, d.data());
        auto& a = alphas.emplace_back(2 * count);
        kernels.mean_alphas(row, means, 4, count, a.data());
        kernels.alphas(row, rgb, 4, count, a.data() + count);
        EXPECT_EQ(d, distances.front()) << kernels.name;
        EXPECT_EQ(a, alphas.front()) << kernels.name;
        EXPECT_TRUE(std::find(d.begin(), d.end(), std::numeric_limits<float>::infinity()) != d.end());
        kernels.between(terms.data(), terms.data() + stride, 0.3f, stride, between.data());
        for (std::size_t i = 0; i < stride; ++i)
          ASSERT_EQ(between[i], terms[i] + 0.3f * (terms[stride + i] - terms[i])) << kernels.name;
        std::vector<std::uint32_t> slid(columns[0].begin(), columns[0].begin() + 16);
        kernels.slide(rgb[0], rgb[1], 16, slid.data());
        for (std::size_t i = 0; i < 16; ++i)
          ASSERT_EQ(slid[i], columns[0][i] + rgb[0][i] - rgb[1][i]) << kernels.name;
      }
    }
}

}  // namespace
}  // namespace floatstage::matting
