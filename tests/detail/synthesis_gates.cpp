#include "tests/detail/synthesis_gates.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include <opencv2/imgproc.hpp>

#include "core/random.h"
#include "detail/synthesis/nearest_points.h"
#include "detail/synthesis/neighbourhoods.h"

namespace floatstage::detail::test {
namespace {

constexpr int kBlock = 256;                                // px a side of a spectrum
constexpr int kWindow = 64;                                // of a variance
constexpr int kCopied = 17;                                // "above 16 x 16"
constexpr int kBeside = 8;                                 // px from a border
constexpr std::size_t kAsked = 6000, kCompared = 400'000;  // neighbourhoods, chosen at random

cv::Mat grey_of(const Image& image) {
  cv::Mat grey;
  const cv::Mat rgb(image.height, image.width, CV_8UC3, const_cast<std::uint8_t*>(image.pixels.data()));
  cv::cvtColor(rgb, grey, cv::COLOR_RGB2GRAY);
  grey.convertTo(grey, CV_32F);
  return grey;
}

bool touches_child(const SynthesisProtocol& p, const Region& r) {
  return std::any_of(p.children.begin(), p.children.end(),
                     [&](const Region& c) { return !common(c, r).empty(); });
}

// Power of the four finest octaves in blocks that no child touches.
std::vector<std::array<double, 4>> blocks_of(const SynthesisProtocol& p, const cv::Mat& grey) {
  cv::Mat window, spectrum;
  cv::createHanningWindow(window, {kBlock, kBlock}, CV_32F);
  std::vector<std::array<double, 4>> out;
  for (int y = 0; y + kBlock <= grey.rows; y += kBlock / 2)
    for (int x = 0; x + kBlock <= grey.cols; x += kBlock / 2) {
      if (touches_child(p, {x, y, x + kBlock, y + kBlock})) continue;
      cv::Mat block = grey(cv::Rect(x, y, kBlock, kBlock)).clone();
      block = (block - cv::mean(block)[0]).mul(window);
      cv::dft(block, spectrum, cv::DFT_COMPLEX_OUTPUT);
      std::array<double, 4> power{};
      for (int v = 0; v < kBlock; ++v)
        for (int u = 0; u <= kBlock / 2; ++u) {
          const double f = std::hypot(u, std::min(v, kBlock - v)) / kBlock;
          if (f < 1.0 / 32 || f > 0.5) continue;
          const auto octave = static_cast<std::size_t>(std::min(3, static_cast<int>(std::log2(f * 32))));
          const auto& c = spectrum.at<cv::Vec2f>(v, u);
          power[octave] += static_cast<double>(c[0] * c[0] + c[1] * c[1]);
        }
      out.push_back(power);
    }
  return out;
}

std::array<double, 4> decibels(const std::vector<std::array<double, 4>>& blocks,
                               const std::vector<std::array<double, 4>>& truth,
                               const std::vector<std::size_t>& which) {
  std::array<double, 4> out{};
  for (std::size_t o = 0; o < 4; ++o) {
    double power = 1e-9, of_truth = 1e-9;
    for (const std::size_t i : which) power += blocks[i][o], of_truth += truth[i][o];
    out[o] = 10 * std::log10(power / of_truth);
  }
  return out;
}

// 1 at the pixels of a level that are 4 px or more from all children.
cv::Mat outside_of(const SynthesisProtocol& p, int level, cv::Size size) {
  cv::Mat mask(size, CV_32F, cv::Scalar(1));
  for (const Region& c : p.children) {
    const int by = 4 << level;
    const Region r =
        common({(c.x0 - by) >> level, (c.y0 - by) >> level, (c.x1 + by) >> level, (c.y1 + by) >> level},
               {0, 0, size.width, size.height});
    mask(cv::Rect(r.x0, r.y0, r.width(), r.height())) = 0;
  }
  return mask;
}

// ln(variance + 1) of 4 directions at 4 levels, in windows of which half or more is outside all children.
std::vector<double> bands_of(const SynthesisProtocol& p, cv::Mat grey) {
  static const std::array<cv::Mat, 4> kernels = {
      cv::Mat((cv::Mat_<float>(3, 3) << -1, 2, -1, -2, 4, -2, -1, 2, -1) / 8),
      cv::Mat((cv::Mat_<float>(3, 3) << -1, -2, -1, 2, 4, 2, -1, -2, -1) / 8),
      cv::Mat((cv::Mat_<float>(3, 3) << -2, 0, 0, 0, 4, 0, 0, 0, -2) / 4),
      cv::Mat((cv::Mat_<float>(3, 3) << 0, 0, -2, 0, 4, 0, -2, 0, 0) / 4)};
  std::vector<double> out;
  for (int level = 0; level < 4; ++level) {
    const cv::Mat mask = outside_of(p, level, grey.size());
    for (const cv::Mat& kernel : kernels) {
      cv::Mat band, squares, weights;
      cv::filter2D(grey, band, CV_32F, kernel, {-1, -1}, 0, cv::BORDER_REFLECT);
      const cv::Size windows(grey.cols / kWindow, grey.rows / kWindow);
      cv::resize(band.mul(band).mul(mask), squares, windows, 0, 0, cv::INTER_AREA);
      cv::resize(mask, weights, windows, 0, 0, cv::INTER_AREA);
      for (int y = 0; y < squares.rows; ++y)
        for (int x = 0; x < squares.cols; ++x)
          if (weights.at<float>(y, x) >= 0.5F)
            out.push_back(std::log(squares.at<float>(y, x) / weights.at<float>(y, x) + 1));
    }
    cv::Mat smaller;
    cv::resize(grey, smaller, {grey.cols / 2, grey.rows / 2}, 0, 0, cv::INTER_AREA);
    grey = smaller;
  }
  return out;
}

double psnr_of(double squares, double count) {
  return squares == 0 ? 99 : std::min(99.0, 10 * std::log10(255.0 * 255.0 * count / squares));
}

double psnr_outside(const SynthesisProtocol& p, const Image& picture) {
  double squares = 0, count = 0;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      for (int c = 0; c < 3 && !p.is_in_child(x, y); ++c) {
        const double off = picture.at(x, y)[c] - p.truth.at(x, y)[c];
        squares += off * off;
        ++count;
      }
  return psnr_of(squares, count);
}

// Means are not rounded: a picture's own rounding is no error of its means.
double psnr_of_means(const SynthesisProtocol& p, const Image& picture) {
  double squares = 0, count = 0;
  for (int y = 0; y < p.low.height; ++y)
    for (int x = 0; x < p.low.width; ++x) {
      if (touches_child(p, {p.zoom * x, p.zoom * y, p.zoom * (x + 1), p.zoom * (y + 1)})) continue;
      for (int c = 0; c < 3; ++c) {
        double sum = 0;
        for (int v = 0; v < p.zoom; ++v)
          for (int u = 0; u < p.zoom; ++u) sum += picture.at(p.zoom * x + u, p.zoom * y + v)[c];
        const double off = sum / (p.zoom * p.zoom) - p.low.at(x, y)[c];
        squares += off * off;
        ++count;
      }
    }
  return psnr_of(squares, count);
}

/// Gradients across lines, and 8 px to both sides of them.
struct Across {
  double there = 0, beside = 0;
  void add(const cv::Mat& grey, int x, int y, bool upright) {
    const auto step = [&](int by) {
      const int u = upright ? x + by : x, v = upright ? y : y + by;
      const int du = upright ? 1 : 0, dv = upright ? 0 : 1;
      if (u - du < 0 || v - dv < 0 || u >= grey.cols || v >= grey.rows) return 0.0;
      return static_cast<double>(std::abs(grey.at<float>(v, u) - grey.at<float>(v - dv, u - du)));
    };
    there += 2 * step(0);
    beside += step(-kBeside) + step(kBeside);
  }
  double off() const { return beside == 0 ? 0 : std::abs(there / beside - 1); }
};

double seam_of(const SynthesisProtocol& p, const cv::Mat& grey, int tile) {
  Across children, tiles;
  for (const Region& c : p.children) {
    for (int y = c.y0; y < c.y1; ++y)
      for (const int x : {c.x0, c.x1}) children.add(grey, x, y, true);
    for (int x = c.x0; x < c.x1; ++x)
      for (const int y : {c.y0, c.y1}) children.add(grey, x, y, false);
  }
  for (int at = tile; tile > 0 && at < grey.cols; at += tile)
    for (int i = 0; i < grey.rows; ++i) {
      tiles.add(grey, at, i, true);
      tiles.add(grey, i, at, false);
    }
  return std::max(children.off(), tiles.off());
}

}  // namespace

int most_used_block(const SynthesisProtocol& p, const Places& places, int width, int height) {
  // The largest square that ends at each pixel and is copied as a whole, by what its last corner shows.
  std::vector<int> square(places.size(), 0);
  std::map<std::int64_t, int> used;
  int most = 0;
  const auto w = static_cast<std::size_t>(width);
  std::int64_t stride =
      0;  // of the children: what lies below a pixel of a copied block lies there below, too
  for (const Region& c : p.children) stride = std::max<std::int64_t>(stride, c.width());
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * w + static_cast<std::size_t>(x);
      if (places[i] < 0 || p.is_in_child(x, y)) continue;
      square[i] = 1;
      if (x == 0 || y == 0) continue;
      if (places[i - 1] + 1 != places[i] || places[i - w] + stride != places[i]) continue;
      square[i] += std::min({square[i - 1], square[i - w], square[i - w - 1]});
      if (square[i] >= kCopied) most = std::max(most, ++used[places[i]]);
    }
  return most;
}

SynthesisJudge::SynthesisJudge(const SynthesisProtocol& protocol) : protocol_(protocol) {
  const cv::Mat grey = grey_of(protocol.truth);
  truth_blocks_ = blocks_of(protocol, grey);
  truth_bands_ = bands_of(protocol, grey);
  truth_energies_ = energies(protocol.truth);
  defocused_.resize(truth_blocks_.size());
  for (std::size_t i = 0; i < defocused_.size(); ++i) defocused_[i] = i;
  std::sort(defocused_.begin(), defocused_.end(),
            [&](std::size_t a, std::size_t b) { return truth_blocks_[a][3] < truth_blocks_[b][3]; });
  defocused_.resize(std::max<std::size_t>(1, defocused_.size() / 10));
}

SynthesisJudge::Energies SynthesisJudge::energies(const Image& picture) const {
  const SynthesisProtocol& p = protocol_;
  const ColorGrid truth = to_colors(p.truth), colors = to_colors(picture);
  Grid<std::uint8_t> inside(truth.region, 0);
  for (const Region& c : p.children)
    for (int y = c.y0 + 2; y < c.y1 - 2; ++y)
      for (int x = c.x0 + 2; x < c.x1 - 2; ++x) inside.at(x, y) = 1;
  const Neighbourhoods basis(truth, inside);
  const auto d = static_cast<std::size_t>(basis.dimensions());
  Random random(5);
  // Of the children, and of the picture outside them.
  const auto chosen = [&](bool in_child, std::size_t count) {
    std::vector<float> points;
    while (points.size() < count * d) {
      const int x = 2 + static_cast<int>(random.next() % static_cast<std::uint64_t>(picture.width - 4));
      const int y = 2 + static_cast<int>(random.next() % static_cast<std::uint64_t>(picture.height - 4));
      if (in_child ? !inside.at(x, y) : p.is_in_child(x, y, 2)) continue;
      points.resize(points.size() + d);
      basis.project(in_child ? truth : colors, x, y, &points[points.size() - d]);
    }
    return points;
  };
  const auto mean = [&](const std::vector<float>& asked, const std::vector<float>& compared) {
    const NearestPoints tree(compared, basis.dimensions());
    double sum = 0;
    for (std::size_t i = 0; i < asked.size(); i += d) {
      NearestPoints::Found found;
      tree.find(&asked[i], 1, 0, &found);
      sum += std::sqrt(found.distance);
    }
    return sum / static_cast<double>(asked.size() / d);
  };
  Energies out;
  out.to_children = mean(chosen(false, kAsked), chosen(true, kCompared));
  out.from_children = mean(chosen(true, kAsked), chosen(false, kCompared));
  return out;
}

SynthesisFigures SynthesisJudge::measure(const Image& picture, int tile, const Places& places) const {
  SynthesisFigures out;
  const cv::Mat grey = grey_of(picture);
  const std::vector<std::array<double, 4>> blocks = blocks_of(protocol_, grey);
  std::vector<std::size_t> all(blocks.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  out.spectrum = decibels(blocks, truth_blocks_, all);
  out.defocused = decibels(blocks, truth_blocks_, defocused_);
  const Energies found = energies(picture);
  out.to_children = found.to_children / truth_energies_.to_children;
  out.from_children = found.from_children / truth_energies_.from_children;
  const std::vector<double> bands = bands_of(protocol_, grey);
  for (std::size_t i = 0; i < bands.size(); ++i)
    out.sub_bands += std::abs(bands[i] - truth_bands_[i]) / static_cast<double>(bands.size());
  out.downsampled = psnr_of_means(protocol_, picture);
  out.seam = seam_of(protocol_, grey, tile);
  if (!places.empty()) out.repeats = most_used_block(protocol_, places, picture.width, picture.height);
  out.psnr = psnr_outside(protocol_, picture);
  return out;
}

std::vector<std::string> failed_gates(const SynthesisFigures& f) {
  const auto within_3_db = [](const std::array<double, 4>& octaves) {
    return std::all_of(octaves.begin(), octaves.end(), [](double db) { return std::abs(db) <= 3; });
  };
  std::vector<std::string> out;
  if (!within_3_db(f.spectrum)) out.emplace_back("G1");
  if (f.from_children > 1.3 || f.to_children < 0.9 || f.to_children > 1.3) out.emplace_back("G2");
  if (f.sub_bands > 0.40) out.emplace_back("G3");
  if (f.downsampled < 40) out.emplace_back("G4");
  if (f.seam > 0.05) out.emplace_back("G5");
  if (f.repeats > 3) out.emplace_back("G6");
  if (!within_3_db(f.defocused)) out.emplace_back("G7");
  return out;
}

std::string to_text(const SynthesisFigures& f) {
  char line[400];
  std::snprintf(line, sizeof line,
                "G1 %+.1f %+.1f %+.1f %+.1f dB; G2 %.2f %.2f; G3 %.3f; G4 %.1f dB; G5 %.3f; G6 %d; G7 %+.1f "
                "%+.1f %+.1f %+.1f dB; PSNR %.2f",
                f.spectrum[0], f.spectrum[1], f.spectrum[2], f.spectrum[3], f.to_children, f.from_children,
                f.sub_bands, f.downsampled, f.seam, f.repeats, f.defocused[0], f.defocused[1], f.defocused[2],
                f.defocused[3], f.psnr);
  std::string out = line;
  for (const std::string& gate : failed_gates(f)) out += " " + gate + "!";
  return out;
}

}  // namespace floatstage::detail::test
