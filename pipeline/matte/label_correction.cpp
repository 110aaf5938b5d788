#include "pipeline/matte/label_correction.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace floatstage::pipeline {
namespace {

constexpr std::size_t kSpeck = 20;  // times as much is said of the label in the picture
constexpr std::size_t kUnmet = 25;  // pixels of a word of which others are asked, about

// A few pixels of a word are seen whole, masks on a grid: calls see(x, y) for those pixels.
template <class See>
void for_asked(const Image& asked, int value, int step, See&& see) {
  const auto is = [&](int x, int y) { return *asked.at(x, y) == value; };
  for (int y = 0; y < asked.height; ++y)
    for (int x = 0; x < asked.width; ++x)
      if (is(x, y) && !(x % step && x > 0 && is(x - 1, y)) && !(y % step && y > 0 && is(x, y - 1))) see(x, y);
}

// The one label that is said of each pixel of the sum, 0 where none or several are.
Image one_said(const LabelsAllowed& may, const Image& matte) {
  Image said(matte.width, matte.height, 1);
  for (std::size_t p = 0; p < may.size(); ++p)
    if (std::popcount(may[p]) == 1 && matte.pixels[p] >= 128)
      said.pixels[p] = static_cast<std::uint8_t>(std::countr_zero(may[p]) + 1);
  return said;
}

// The pixels that hang together with one and say the same; they are taken out of `said`.
std::vector<std::size_t> take_word(Image& said, std::size_t first) {
  const std::uint8_t label = said.pixels[first];
  std::vector<std::size_t> word{first};
  said.pixels[first] = 0;
  const auto width = static_cast<std::size_t>(said.width);
  for (std::size_t i = 0; i < word.size(); ++i) {
    const std::size_t p = word[i], x = p % width;
    const auto go = [&](std::size_t q) {
      if (said.pixels[q] == label) said.pixels[q] = 0, word.push_back(q);
    };
    if (x > 0) go(p - 1);
    if (x + 1 < width) go(p + 1);
    if (p >= width) go(p - width);
    if (p + width < said.pixels.size()) go(p + width);
  }
  return word;
}

Eigen::Vector2d place_of(std::size_t pixel, int width) {
  const auto w = static_cast<std::size_t>(width);
  return {static_cast<double>(pixel % w) + 0.5, static_cast<double>(pixel / w) + 0.5};
}

// Of pixels, the middle of the one nearest to where they are on average.
Eigen::Vector2d middle_of(const std::vector<std::size_t>& pixels, int width) {
  const auto place = [&](std::size_t p) { return place_of(p, width); };
  Eigen::Vector2d mean = Eigen::Vector2d::Zero(), best = mean;
  for (const std::size_t p : pixels) mean += place(p) / static_cast<double>(pixels.size());
  double least = std::numeric_limits<double>::infinity();
  for (const std::size_t p : pixels)
    if (const double away = (place(p) - mean).squaredNorm(); away < least) least = away, best = place(p);
  return best;
}

class Finder {
 public:
  Finder(const recon::LabelVolume& volume, LabelCorrection& out) : volume_(volume), out_(out) {}

  void look(int camera, const LabelsAllowed& may, const Image& matte) {
    Image said = one_said(may, matte);
    const Image shown = volume_.picture(camera, out_.carried);
    for (std::size_t p = 0; p < said.pixels.size(); ++p)
      if (const std::uint8_t label = said.pixels[p]; label > 0)
        hold(camera, label, take_word(said, p), shown);
  }

 private:
  // A word against what the camera shows.
  void hold(int camera, std::uint8_t label, const std::vector<std::size_t>& word, const Image& shown) {
    std::vector<std::size_t> pixels(static_cast<std::size_t>(volume_.labels()) + 1, 0);
    for (const std::size_t p : word) ++pixels[shown.pixels[p]];
    const auto most =
        static_cast<std::uint8_t>(std::max_element(pixels.begin() + 1, pixels.end()) - pixels.begin());
    const std::uint8_t on = pixels[most] == 0 ? 0 : 2 * pixels[label] >= word.size() ? label : most;
    Image part(shown.width, shown.height, 1);
    for (const std::size_t p : word) part.pixels[p] = shown.pixels[p] == on;
    bool any = false;
    for_asked(part, 1, std::max(1, volume_.cell(camera) / 2), [&](int x, int y) {
      const std::size_t v =
          on > 0 ? volume_.seen_at(camera, x, y, out_.carried) : volume_.seen_at(camera, x, y);
      if (v >= volume_.size() || out_.carried[v] != on) return;
      any = true;
      out_.seen[label - 1U].push_back(v);
      if (on != label && !out_.anew[v])
        for (const std::size_t piece : volume_.piece_of(v, out_.carried)) out_.anew[piece] = 1;
    });
    if (on == label || !any) return;
    if (on > 0) out_.lost |= std::uint32_t{1} << (on - 1);
    out_.said |= std::uint32_t{1} << (label - 1);
  }

  const recon::LabelVolume& volume_;
  LabelCorrection& out_;
};

}  // namespace

std::vector<std::vector<std::size_t>> pointed_at(const recon::LabelVolume& volume,
                                                 const std::map<int, LabelsAllowed>& said,
                                                 const std::vector<Image>& mattes) {
  std::vector<std::vector<std::size_t>> voxels(static_cast<std::size_t>(volume.labels()));
  for (const auto& [camera, may] : said) {
    const Image labels = one_said(may, mattes[static_cast<std::size_t>(camera)]);
    Image asked = labels;
    for (std::uint8_t& a : asked.pixels) a = a > 0;
    for_asked(asked, 1, std::max(1, volume.cell(camera) / 2), [&](int x, int y) {
      const std::size_t v = volume.seen_at(camera, x, y);
      if (v < volume.size()) voxels[*labels.at(x, y) - 1U].push_back(v);
    });
  }
  return voxels;
}

std::vector<NowhereWord> words_nowhere(const recon::LabelVolume* volume,
                                       const std::map<int, LabelsAllowed>& said,
                                       const std::vector<Image>& mattes) {
  std::vector<NowhereWord> nowhere;
  for (const auto& [camera, may] : said) {
    const Image& matte = mattes[static_cast<std::size_t>(camera)];
    if (matte.empty()) continue;
    Image left = one_said(may, matte);
    std::map<std::uint8_t, std::size_t> all;
    for (const std::uint8_t label : left.pixels) ++all[label];
    for (std::size_t p = 0; p < left.pixels.size(); ++p) {
      const std::uint8_t label = left.pixels[p];
      if (label == 0) continue;
      const std::vector<std::size_t> word = take_word(left, p);
      if (kSpeck * word.size() < all[label]) continue;
      Image part(matte.width, matte.height, 1);
      for (const std::size_t q : word) part.pixels[q] = 1;
      std::size_t asked = 0;
      std::vector<std::size_t> unmet;
      for_asked(part, 1, volume ? std::max(1, volume->cell(camera) / 2) : 1, [&](int x, int y) {
        ++asked;
        if (!volume || volume->seen_at(camera, x, y) >= volume->size()) unmet.push_back(part.offset(x, y));
      });
      if (2 * unmet.size() <= asked) continue;
      NowhereWord& lost = nowhere.emplace_back();
      lost.label = label, lost.camera = camera, lost.at = middle_of(word, matte.width);
      for (std::size_t i = 0; i < unmet.size(); i += 1 + unmet.size() / kUnmet)
        lost.unmet.push_back(place_of(unmet[i], matte.width));
    }
  }
  return nowhere;
}

LabelCorrection find_correction(const recon::LabelVolume& volume, const std::map<int, LabelsAllowed>& said,
                                const std::vector<Image>& mattes, std::vector<std::uint8_t> carried) {
  LabelCorrection correction;
  correction.carried = std::move(carried);
  correction.anew.assign(volume.size(), 0);
  correction.seen.resize(static_cast<std::size_t>(volume.labels()));
  Finder finder(volume, correction);
  for (const auto& [camera, may] : said)
    if (const Image& matte = mattes[static_cast<std::size_t>(camera)]; !matte.empty())
      finder.look(camera, may, matte);
  return correction;
}

bool colors_tell(const LabelCorrection& correction, const matting::LabelPalette& palette, int labels,
                 double most) {
  if (correction.lost == 0) return false;
  const auto in = [](std::uint32_t set, int label) { return (set >> (label - 1) & 1) != 0; };
  for (int lost = 1; lost <= labels; ++lost)
    for (int said = 1; said <= labels; ++said) {
      if (lost == said || !in(correction.lost, lost) || !in(correction.said, said)) continue;
      if (!palette.knows(lost) || !palette.knows(said) || palette.alike(lost, said) > most) return false;
    }
  return true;
}

}  // namespace floatstage::pipeline
