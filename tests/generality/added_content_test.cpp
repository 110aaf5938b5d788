// What cameras, recorders and converters add to pictures, on every stage: found where it was added, and not
// where it was not. Short form: stages of 320 pixels; recorded sets always at their own size.
#include <cstdio>
#include <cstdlib>

#include <gtest/gtest.h>

#include "core/added_search.h"
#include "core/statistics.h"
#include "core/text.h"
#include "tests/generality/sets.h"
#include "tests/support/burnt_in.h"
#include "tests/support/long_tests.h"
#include "tests/support/real_data.h"

namespace floatstage::generality {
namespace {

using Pictures = std::vector<std::vector<Image>>;  // [camera][instant]

Pictures pictures_of(const SetName& name) {
  const StageSet set = name.load(!name.data.empty() || wants_long_tests());
  Pictures all(set.rig.cameras.size());
  for (const auto& instant : set.pictures)
    for (std::size_t i = 0; i < all.size(); ++i) all[i].push_back(instant[i]);
  return all;
}

class OnEverySet : public testing::TestWithParam<SetName> {
 protected:
  void SetUp() override {
    if (!GetParam().data.empty()) FLOATSTAGE_NEEDS_DATA(GetParam().data);
  }
};

TEST_P(OnEverySet, NothingIsFoundWhereNothingWasAdded) {
  const Pictures pictures = pictures_of(GetParam());
  const std::vector<AddedContent> found = find_added(pictures);
  // Converters laid a black line around all pictures of both domes.
  const bool framed = GetParam().name.starts_with("green-dome");
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_EQ(found[i], (framed ? AddedContent{1, 1, 1, 1} : AddedContent()))
        << GetParam().name << ", camera " << i << ": " << describe(found[i]);
}

// Share of `of` that `boxes` hold.
double held(const PixelBox& of, const std::vector<PixelBox>& boxes) {
  int in = 0;
  for (int y = of.y; y < of.y + of.height; ++y)
    for (int x = of.x; x < of.x + of.width; ++x)
      for (const PixelBox& b : boxes)
        if (x >= b.x && y >= b.y && x < b.x + b.width && y < b.y + b.height) {
          ++in;
          break;
        }
  return static_cast<double>(in) / (of.width * of.height);
}

struct Case {
  const char* what;
  Stamp stamp;
  bool numbered = false;  // each camera has its own number at the end
  int quality = 100;      // of the JPEG
};

const std::vector<Case> kCases = {
    {"sans", {.words = "2026-11-23 10:41:07"}},
    {"bold, outlined, below",
     {.words = "10:41:07:12", .x = 0.6, .y = 0.9, .font = 2, .look = StampLook::Outlined}},
    {"serif on a box", {.words = "REC 00:01:23", .x = 0.7, .y = 0.02, .font = 3, .look = StampLook::Boxed}},
    {"JPEG", {.words = "23/11/2026 10:41", .size = 0.045, .font = 4, .look = StampLook::Outlined}, false, 75},
    {"names",
     {.words = "CAMERA 0", .x = 0.02, .y = 0.92, .size = 0.045, .font = 2, .look = StampLook::Boxed},
     true},
};

TEST_P(OnEverySet, WhatWasAddedIsFound) {
  const Pictures plain = pictures_of(GetParam());
  if (plain.size() < 3) GTEST_SKIP() << "one camera";
  for (const Case& c : kCases) {
    Pictures pictures = plain;
    std::vector<PixelBox> boxes;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      Stamp stamp = c.stamp;
      if (c.numbered) stamp.words += text(1 + i % 9);
      pictures[i].resize(1);
      boxes.push_back(burn_in(stamp, pictures[i][0]));
      if (c.quality < 100) pictures[i][0] = coded(pictures[i][0], c.quality);
    }
    const std::vector<AddedContent> found = find_added(pictures);
    double worst = 1, largest = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      double area = 0;
      for (const PixelBox& b : found[i].overlays) area += b.width * b.height;
      worst = std::min(worst, held(boxes[i], found[i].overlays));
      largest = std::max(largest, area / (boxes[i].width * boxes[i].height));
      EXPECT_LE(found[i].top + found[i].left, 2)
          << GetParam().name << ", " << c.what << ": " << describe(found[i]);
    }
    std::printf("%-30s %-24s held %.3f, at most %.2f times its area\n", GetParam().name.c_str(), c.what,
                worst, largest);
    EXPECT_GE(worst, 0.85) << GetParam().name << ", " << c.what;
    EXPECT_LE(largest, 3.5) << GetParam().name << ", " << c.what;
  }
}

// Bars as unlike the stage as bars are as a rule: black ones before black cloth are not told from it.
std::uint8_t bars_grey(const Pictures& pictures) {
  std::vector<int> values(pictures[0][0].pixels.begin(), pictures[0][0].pixels.end());
  return median(std::move(values)) < 40 ? 235 : 0;
}

TEST_P(OnEverySet, BarsAreFoundToThePixel) {
  const Pictures plain = pictures_of(GetParam());
  const std::uint8_t grey = bars_grey(plain);
  for (const AddedContent& bars :
       {AddedContent{.top = 24, .bottom = 24}, AddedContent{.left = 17, .right = 9}})
    for (const int quality : {100, 75})
      for (std::size_t i = 0; i < plain.size(); ++i) {
        std::vector<Image> pictures = plain[i];
        for (Image& p : pictures) {
          p = with_bars(p, bars, grey);
          if (bars.top) burn_in({.words = "10:41:07", .x = 0.05, .y = 0.01, .size = 0.02}, p);
          if (quality < 100) p = coded(p, quality);
        }
        const AddedContent found = added_bars(pictures);
        const auto near = [&](int a, int b) { return std::abs(a - b) <= (quality < 100 ? 1 : 0); };
        const bool right = bars.top ? near(found.top, bars.top) && near(found.bottom, bars.bottom)
                                    : near(found.left, bars.left) && near(found.right, bars.right);
        EXPECT_TRUE(right) << GetParam().name << ", camera " << i << ", JPEG " << quality << ": "
                           << describe(found) << " for " << describe(bars);
      }
}

INSTANTIATE_TEST_SUITE_P(AddedContent, OnEverySet, testing::ValuesIn(all_sets()), [](const auto& set) {
  std::string name = set.param.name;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
});

}  // namespace
}  // namespace floatstage::generality
