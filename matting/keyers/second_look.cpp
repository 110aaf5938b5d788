// Method:  one cut between the colours of a key's two sides
// Paper:   C. Rother, V. Kolmogorov, A. Blake, "GrabCut", 2004
// Differs: a key in the place of the user, once; histograms on a square-root scale
// ADR:     0170, 0347

#include "matting/keyers/second_look.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "matting/color_model.h"
#include "matting/frame_cut.h"
#include "matting/keyers/alpha_bits.h"

namespace floatstage::matting {
namespace {

constexpr double kReach = 0.03;  // of the longer side: how far from the key's outline pixels are asked
constexpr float kWord = 2.5f;    // log-odds of the key's own word
constexpr float kMost = 4;       // log-odds of a colour, at most
constexpr double kSmooth = 3;    // as for clips (video/clip_cut.h)

using Table = std::array<std::uint8_t, 256>;

Table square_roots() {
  Table table;
  for (std::size_t v = 0; v < table.size(); ++v)
    table[v] = static_cast<std::uint8_t>(std::lround(std::sqrt(255.0 * static_cast<double>(v))));
  return table;
}

// How often colours occur on either side, and what that says of a colour.
class Sides {
 public:
  explicit Sides(const Table& roots) {
    for (std::size_t v = 0; v < roots.size(); ++v) {
      const std::uint8_t red[] = {roots[v], 0, 0}, green[] = {0, roots[v], 0}, blue[] = {0, 0, roots[v]};
      bins_[0][v] = static_cast<std::uint16_t>(ColorModel::bin(red));
      bins_[1][v] = static_cast<std::uint16_t>(ColorModel::bin(green));
      bins_[2][v] = static_cast<std::uint16_t>(ColorModel::bin(blue));
    }
  }

  void learn(const Image& picture, const BitRows& subject, const BitRows& stage) {
    count(picture, subject, subject_);
    count(picture, stage, stage_);
  }
  float odds(const std::uint8_t* rgb) {
    float& odds = odds_.data()[bin(rgb)];
    if (std::isnan(odds)) {
      const float ratio = subject_.likelihood(bin(rgb)) / stage_.likelihood(bin(rgb));
      odds = std::clamp(std::log(ratio), -kMost, kMost);
    }
    return odds;
  }

 private:
  std::size_t bin(const std::uint8_t* rgb) const {
    return static_cast<std::size_t>(bins_[0][rgb[0]] + bins_[1][rgb[1]] + bins_[2][rgb[2]]);
  }
  void count(const Image& picture, const BitRows& where, ColorModel& model) const {
    // Neighbours often have the same colour: counting them in turns saves waiting for the last count.
    std::vector<std::uint32_t> counts[2];
    for (auto& c : counts) c.resize(ColorModel::kBins);
    std::uint32_t *even = counts[0].data(), *odd = counts[1].data();
    for (int y = 0; y < where.height(); ++y) {
      const std::uint8_t* row = picture.at(0, y);
      for_each_bit(where, y, [&](int x) { ++(x % 2 != 0 ? odd : even)[bin(row + 3 * x)]; });
    }
    for (std::size_t b = 0; b < ColorModel::kBins; ++b)
      model.add(b, static_cast<float>(counts[0][b] + counts[1][b]));
    model.finish();
  }

  std::array<std::array<std::uint16_t, 256>, 3> bins_;
  ColorModel subject_, stage_;
  std::vector<float> odds_ = std::vector<float>(ColorModel::kBins, std::numeric_limits<float>::quiet_NaN());
};

}  // namespace

Image second_look(const Image& picture, const Image& key) {
  const int w = key.width, h = key.height;
  const int reach = std::max(1, static_cast<int>(std::lround(kReach * std::max(w, h))));
  BitMorphology morphology;
  BitRows subject, inside, around, stage, rim;
  bits_of(key, {0, 0, w, h}, 128, subject);
  erode_square(morphology, subject, std::max(1, reach / 10), inside);
  dilate_square(morphology, subject, reach, around);
  const BitBox asked = bounding_box(around);
  rim.resize(w, h);
  rim.clear();
  stage.resize(w, h);
  bool any_stage = false;
  for (int y = 0; y < h; ++y) {
    if (y < reach || y >= h - reach || 2 * reach >= w) {
      rim.set(y, 0, w);
    } else {
      rim.set(y, 0, reach);
      rim.set(y, w - reach, w);
    }
    for (std::size_t i = 0; i < stage.words(); ++i) stage.row(y)[i] = ~around.row(y)[i];
    stage.trim(y);
    any_stage = any_stage || any_between(stage.row(y), 0, w);
  }
  if (bounding_box(inside).empty() || !any_stage) return key;
  for (std::size_t i = 0; i < stage.all().size(); ++i) {
    stage.all()[i] |= rim.all()[i];
    inside.all()[i] &= ~rim.all()[i];
  }
  const Table roots = square_roots();
  Sides sides(roots);
  sides.learn(picture, inside, stage);

  // What is asked, and the neighbours of that.
  const BitBox box = grown(asked, 1, around);
  Image part(box.x1 - box.x0, box.y1 - box.y0, 3);
  CutEvidence evidence;
  evidence.odds.assign(part.pixels.size() / 3, -kWord);
  evidence.asked.assign(part.pixels.size() / 3, 0);
  for (int y = 0; y < part.height; ++y) {
    const int py = box.y0 + y;
    const std::uint8_t *from = picture.at(box.x0, py), *alpha = key.at(box.x0, py);
    std::uint8_t* to = part.at(0, y);
    for (int i = 0; i < 3 * part.width; ++i) to[i] = roots[from[i]];
    const std::size_t first = static_cast<std::size_t>(y) * static_cast<std::size_t>(part.width);
    float* odds = evidence.odds.data() + first;
    std::uint8_t* asks = evidence.asked.data() + first;
    for_each_bit(around, py, [&](int px) {
      const int x = px - box.x0;
      const float word = rim.at(px, py) ? -kWord : kWord * (static_cast<float>(alpha[x]) / 127.5f - 1);
      odds[x] = word + sides.odds(from + 3 * x);
      asks[x] = 1;
    });
  }
  const Image cut = cut_frame(part, evidence, kSmooth);
  Image out = key;
  for (int y = 0; y < part.height; ++y) {
    const std::uint8_t* decided = cut.at(0, y);
    std::uint8_t* alpha = out.at(box.x0, box.y0 + y);
    for (int x = 0; x < part.width; ++x)
      if ((alpha[x] >= 128) != (decided[x] >= 128)) alpha[x] = decided[x] >= 128 ? 255 : 0;
  }
  return out;
}

}  // namespace floatstage::matting
