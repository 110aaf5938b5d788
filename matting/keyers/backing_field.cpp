// Method:  a model of the backing, place by place, grown from the picture's rim
// Paper:   after R. Adams, L. Bischof, "Seeded region growing", 1994, and for the edges of A. R. Smith, J. F.
// Blinn,
//          "Blue screen matting", 1996
// Differs: regions are compared with the mean and spread of what was grown nearby; how bright the rim may be
// is
//          chosen by the sharpness of the outline that remains
// ADR:     0170

#include "matting/keyers/backing_field.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "core/check.h"
#include "matting/keyers/field_rows.h"

namespace floatstage::matting {
namespace {

constexpr int kCells = 160;        // along the longer side: texture of cloth and noise average out in a cell
constexpr int kRounds = 6;         // of growing, at most
constexpr float kRounding = 0.5f;  // 8-bit steps: what a mean of rounded values may be off by
constexpr double kSharp = 0.85;    // of the sharpest outline

using Spread = std::array<cv::Mat, 6>;  // 00 01 02 11 12 22

// One picture in cells.
struct Cells {
  cv::Mat mean;                    // 3 x CV_32F: of the cell's pixels that are not left out
  std::array<cv::Mat, 6> squares;  // CV_32F: means of products, same pixels
  cv::Mat usable;                  // CV_32F: 1 where most pixels are not left out
  cv::Mat grey;                    // CV_32F
  cv::Mat backing;                 // CV_32F: 1 where found to be backing
};

// Twice a box: nearly a cone, in a time that does not depend on its radius.
cv::Mat spread_out(const cv::Mat& in, int radius) {
  cv::Mat out;
  const cv::Size size(2 * radius + 1, 2 * radius + 1);
  cv::boxFilter(in, out, CV_32F, size, {-1, -1}, true, cv::BORDER_CONSTANT);
  cv::boxFilter(out, out, CV_32F, size, {-1, -1}, true, cv::BORDER_CONSTANT);
  return out;
}

Cells cells_of(const Image& picture, const Image* left_out, cv::Size grid) {
  const cv::Mat rgb(picture.height, picture.width, CV_8UC3, const_cast<std::uint8_t*>(picture.pixels.data()));
  cv::Mat values, weight(rgb.size(), CV_32F, cv::Scalar(1));
  rgb.convertTo(values, CV_32F);
  if (left_out) {
    const cv::Mat mask(rgb.size(), CV_8U, const_cast<std::uint8_t*>(left_out->pixels.data()));
    weight.setTo(0, mask);
    values.setTo(0, mask);
  }
  Cells cells;
  cv::Mat share, planes[3], small[3];
  cv::resize(weight, share, grid, 0, 0, cv::INTER_AREA);
  cells.usable = cv::Mat::zeros(grid, CV_32F);
  cells.usable.setTo(1, share >= 0.5f);
  const cv::Mat per = cv::max(share, 1e-6f);
  cv::split(values, planes);
  for (int c = 0; c < 3; ++c) {
    cv::resize(planes[c], small[c], grid, 0, 0, cv::INTER_AREA);
    small[c] /= per;
  }
  for (int i = 0, q = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j, ++q) {
      cv::resize(planes[i].mul(planes[j]), cells.squares[static_cast<std::size_t>(q)], grid, 0, 0,
                 cv::INTER_AREA);
      cells.squares[static_cast<std::size_t>(q)] /= per;
    }
  cv::merge(small, 3, cells.mean);
  cells.grey = 0.299f * small[0] + 0.587f * small[1] + 0.114f * small[2];
  cells.backing = cv::Mat::zeros(grid, CV_32F);
  return cells;
}

// Means of the backing in windows, over all pictures.
struct Statistics {
  cv::Mat known, mean;  // share of the window that is backing (summed over the pictures); colour
  Spread of_cells, of_pixels;
};

Statistics statistics_of(const std::vector<Cells>& pictures, int radius, bool pixels) {
  Statistics s;
  std::array<cv::Mat, 3> mean;
  auto add = [](cv::Mat& sum, const cv::Mat& more) { sum = sum.empty() ? more : cv::Mat(sum + more); };
  for (const Cells& cells : pictures) {
    cv::Mat planes[3];
    cv::split(cells.mean, planes);
    add(s.known, spread_out(cells.backing, radius));
    for (std::size_t i = 0, q = 0; i < 3; ++i) {
      add(mean[i], spread_out(planes[i].mul(cells.backing), radius));
      for (std::size_t j = i; j < 3; ++j, ++q) {
        add(s.of_cells[q], spread_out(planes[i].mul(planes[j]).mul(cells.backing), radius));
        if (pixels) add(s.of_pixels[q], spread_out(cells.squares[q].mul(cells.backing), radius));
      }
    }
  }
  const cv::Mat per = cv::max(s.known, 1e-6f);
  for (cv::Mat& m : mean) m /= per;
  for (std::size_t i = 0, q = 0; i < 3; ++i)
    for (std::size_t j = i; j < 3; ++j, ++q)
      for (Spread* spread : {&s.of_cells, &s.of_pixels}) {
        cv::Mat& m = (*spread)[q];
        if (m.empty()) continue;
        m = m / per - mean[i].mul(mean[j]);
        if (i == j) m = cv::max(m, 0.0f) + kRounding * kRounding;
      }
  cv::merge(mean.data(), 3, s.mean);
  return s;
}

// Lower triangle W with W^T W the inverse of a spread: 00 10 11 20 21 22 (Cholesky of it, inverted).
std::array<float, 6> whitening(const Spread& spread, int y, int x) {
  auto at = [&](std::size_t q) { return static_cast<double>(spread[q].at<float>(y, x)); };
  constexpr double kLeast = 1e-3;
  const double l00 = std::sqrt(std::max(at(0), kLeast)), l10 = at(1) / l00, l20 = at(2) / l00;
  const double l11 = std::sqrt(std::max(at(3) - l10 * l10, kLeast)), l21 = (at(4) - l20 * l10) / l11;
  const double l22 = std::sqrt(std::max(at(5) - l20 * l20 - l21 * l21, kLeast));
  const double w00 = 1 / l00, w11 = 1 / l11, w22 = 1 / l22;
  const double w10 = -l10 * w00 * w11, w21 = -l21 * w11 * w22, w20 = -(l20 * w00 + l21 * w10) * w22;
  return {static_cast<float>(w00), static_cast<float>(w10), static_cast<float>(w11),
          static_cast<float>(w20), static_cast<float>(w21), static_cast<float>(w22)};
}

// The median over the backing of a pixel's standard deviation in grey.
float grey_noise(const Statistics& s, const std::vector<Cells>& pictures) {
  constexpr double l[] = {0.299, 0.587, 0.114};
  std::vector<float> all;
  for (const Cells& cells : pictures)
    for (int y = 0; y < cells.backing.rows; ++y)
      for (int x = 0; x < cells.backing.cols; ++x) {
        if (cells.backing.at<float>(y, x) == 0) continue;
        double variance = 0;
        for (std::size_t i = 0, q = 0; i < 3; ++i)
          for (std::size_t j = i; j < 3; ++j, ++q)
            variance += (i == j ? 1 : 2) * l[i] * l[j] * static_cast<double>(s.of_pixels[q].at<float>(y, x));
        all.push_back(static_cast<float>(std::sqrt(std::max(variance, 0.0))));
      }
  if (all.empty()) return 0;
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  return *middle;
}

float luma(float r, float g, float b) { return 0.299f * r + 0.587f * g + 0.114f * b; }

// Grows the backing in the cells of all pictures.
class Growth {
 public:
  Growth(std::vector<Cells>& pictures, const FieldOptions& options)
      : pictures_(pictures),
        options_(options),
        rows_(pictures.front().mean.rows),
        cols_(pictures.front().mean.cols),
        radius_(std::max(1, static_cast<int>(std::lround(options.reach * std::max(rows_, cols_))))),
        rim_(std::max(1, static_cast<int>(std::lround(options.rim * std::max(rows_, cols_))))) {}

  // Until nothing changes; what was grown to a lower level is gone on with.
  void to_level(float brightest) {
    for (Cells& cells : pictures_)
      for (int y = 0; y < rows_; ++y)
        for (int x = 0; x < cols_; ++x)
          if (in_rim(y, x) && cells.usable.at<float>(y, x) > 0 && cells.grey.at<float>(y, x) <= brightest)
            cells.backing.at<float>(y, x) = 1;
    for (int round = 0; round < kRounds; ++round) {
      const Statistics s = statistics_of(pictures_, radius_, false);
      bool changed = false;
      for (Cells& cells : pictures_) changed |= grow(cells, s, brightest);
      if (!changed) break;
    }
  }

  // The mean difference of colour across the outline, over a cell on either side.
  double sharpness() const {
    double sum = 0;
    long count = 0;
    for (const Cells& cells : pictures_)
      for (int y = 2; y + 2 < rows_; ++y)
        for (int x = 2; x + 2 < cols_; ++x) {
          if (cells.backing.at<float>(y, x) == 0) continue;
          for (const auto& [dx, dy] : kSteps) {
            const int x1 = x + dx, y1 = y + dy;
            if (cells.backing.at<float>(y1, x1) > 0 || cells.usable.at<float>(y1, x1) == 0) continue;
            sum += options_.darker_too
                       ? cells.grey.at<float>(y1 + dy, x1 + dx) - cells.grey.at<float>(y - dy, x - dx)
                       : step(cells, y - dy, x - dx, y1 + dy, x1 + dx);
            ++count;
          }
        }
    return count > 0 ? sum / static_cast<double>(count) : 0;
  }

  int radius() const { return radius_; }

 private:
  static constexpr std::pair<int, int> kSteps[] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};

  bool in_rim(int y, int x) const { return x < rim_ || y < rim_ || x >= cols_ - rim_ || y >= rows_ - rim_; }
  static float step(const Cells& cells, int y0, int x0, int y1, int x1) {
    return static_cast<float>(cv::norm(cells.mean.at<cv::Vec3f>(y0, x0) - cells.mean.at<cv::Vec3f>(y1, x1)));
  }

  // How much the backing's colour changes from a cell to the next, as a rule, there.
  cv::Mat usual_step(const Cells& cells) const {
    cv::Mat sum = cv::Mat::zeros(rows_, cols_, CV_32F), count = sum.clone();
    for (int y = 0; y < rows_; ++y)
      for (int x = 0; x < cols_; ++x)
        for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(0, 1)}) {
          if (x + dx >= cols_ || y + dy >= rows_) continue;
          if (cells.backing.at<float>(y, x) == 0 || cells.backing.at<float>(y + dy, x + dx) == 0) continue;
          const float d = step(cells, y, x, y + dy, x + dx);
          sum.at<float>(y, x) += d * d;
          count.at<float>(y, x) += 1;
        }
    cv::Mat mean = spread_out(sum, radius_) / cv::max(spread_out(count, radius_), 1e-6f);
    cv::sqrt(mean, mean);
    return mean + kRounding;
  }

  // From the rim over cells that look like the backing there, never across an edge of the picture's own.
  bool grow(Cells& cells, const Statistics& s, float brightest) const {
    const float sigmas = static_cast<float>(options_.sigmas);
    auto alike = [&](int y, int x) {
      if (cells.usable.at<float>(y, x) == 0 || cells.grey.at<float>(y, x) > brightest) return false;
      if (s.known.at<float>(y, x) < options_.least_known) return false;
      const cv::Vec3f d = cells.mean.at<cv::Vec3f>(y, x) - s.mean.at<cv::Vec3f>(y, x);
      if (options_.darker_too && luma(d[0], d[1], d[2]) < 0) return true;
      return whitened_length(whitening(s.of_cells, y, x).data(), d[0], d[1], d[2]) < sigmas;
    };
    const cv::Mat usual = usual_step(cells);
    cv::Mat found = cv::Mat::zeros(rows_, cols_, CV_32F);
    std::vector<cv::Point> front;
    auto take = [&](int y, int x) {
      found.at<float>(y, x) = 1;
      front.emplace_back(x, y);
    };
    for (int y = 0; y < rows_; ++y)
      for (int x = 0; x < cols_; ++x)
        if (in_rim(y, x) && alike(y, x)) take(y, x);
    while (!front.empty()) {
      const cv::Point p = front.back();
      front.pop_back();
      for (const auto& [dx, dy] : kSteps) {
        const int x = p.x + dx, y = p.y + dy;
        if (x < 0 || y < 0 || x >= cols_ || y >= rows_ || found.at<float>(y, x) > 0) continue;
        if (step(cells, p.y, p.x, y, x) <= sigmas * usual.at<float>(p.y, p.x) && alike(y, x)) take(y, x);
      }
    }
    const bool changed = cv::countNonZero(found != cells.backing) > 0;
    cells.backing = found;
    return changed;
  }

  std::vector<Cells>& pictures_;
  const FieldOptions& options_;
  int rows_, cols_, radius_, rim_;
};

}  // namespace

std::optional<BackingField> learn_field(const std::vector<Image>& pictures,
                                        const std::vector<Image>& left_out, const FieldOptions& options) {
  FLOATSTAGE_CHECK(left_out.empty() || left_out.size() == pictures.size(), "a mask for every picture");
  if (pictures.empty() || pictures.front().empty()) return std::nullopt;
  const int width = pictures.front().width, height = pictures.front().height;
  const double shrink = std::min(1.0, static_cast<double>(kCells) / std::max(width, height));
  const cv::Size grid(std::max(1, static_cast<int>(std::lround(width * shrink))),
                      std::max(1, static_cast<int>(std::lround(height * shrink))));
  std::vector<Cells> cells;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    FLOATSTAGE_CHECK(pictures[i].channels == 3, "RGB pictures");
    if (pictures[i].width != width || pictures[i].height != height) continue;
    cells.push_back(cells_of(pictures[i], left_out.empty() ? nullptr : &left_out[i], grid));
  }

  // The levels of the ladder are half an octave apart; 8-bit steps below the first are black.
  struct Rung {
    float level;
    double sharp;
    std::vector<cv::Mat> backing;
  };
  std::vector<Rung> ladder;
  Growth growth(cells, options);
  for (float level = 8; level < 256; level *= 1.41421356f) {
    growth.to_level(level);
    ladder.push_back({level, growth.sharpness(), {}});
    for (const Cells& c : cells) ladder.back().backing.push_back(c.backing.clone());
  }
  double sharpest = 0;
  for (const Rung& rung : ladder) sharpest = std::max(sharpest, rung.sharp);
  // Where nothing brighter stands on the stage, all of it is backing.
  const auto best = sharpest <= 0 ? ladder.end() - 1
                                  : std::find_if(ladder.begin(), ladder.end(),
                                                 [&](const Rung& r) { return r.sharp >= kSharp * sharpest; });
  double share = 0, grey = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    cells[i].backing = best->backing[i];
    share += cv::mean(cells[i].backing)[0] / static_cast<double>(cells.size());
    grey += cv::mean(cells[i].grey.mul(cells[i].backing))[0] / static_cast<double>(cells.size());
  }
  if (share == 0) return std::nullopt;

  const Statistics s = statistics_of(cells, growth.radius(), true);
  BackingField field;
  field.cols_ = grid.width;
  field.rows_ = grid.height;
  field.share_ = share;
  field.grey_ = grey / share;
  field.brightest_ = best->level;
  field.darker_too_ = options.darker_too;
  field.sigmas_ = static_cast<float>(options.sigmas);
  field.noise_ = grey_noise(s, cells);
  constexpr std::size_t n = FieldRow::kTerms;
  const std::size_t stride = field.stride(), rows = static_cast<std::size_t>(grid.height);
  field.pixel_.resize(rows * n * stride);
  field.cell_.resize(rows * n * stride);
  field.known_.resize(rows * stride);
  for (int y = 0; y < grid.height; ++y)
    for (std::size_t i = 0; i < stride; ++i) {
      const int x = std::min(static_cast<int>(i), grid.width - 1);
      const std::size_t row = static_cast<std::size_t>(y);
      const cv::Vec3f m = s.mean.at<cv::Vec3f>(y, x);
      for (const auto& [terms, spread] :
           {std::pair(&field.pixel_, &s.of_pixels), std::pair(&field.cell_, &s.of_cells)}) {
        const std::array<float, 6> w = whitening(*spread, y, x);
        for (std::size_t k = 0; k < n; ++k)
          (*terms)[(row * n + k) * stride + i] = k < 3 ? m[static_cast<int>(k)] : w[k - 3];
      }
      field.known_[row * stride + i] = s.known.at<float>(y, x) >= options.least_known ? 1.0f : 0.0f;
    }
  return field;
}

const float* BackingField::terms(Scale scale, int row) const {
  return (scale == Scale::Cell ? cell_ : pixel_).data() +
         static_cast<std::size_t>(row) * FieldRow::kTerms * stride();
}

int BackingField::cell(int width) const { return std::max(1, width / std::max(1, cols_)); }

std::vector<float> BackingField::distances(const Image& picture, Scale scale) const {
  const int w = picture.width, h = picture.height;
  cv::Mat rgb(h, w, CV_8UC3, const_cast<std::uint8_t*>(picture.pixels.data()));
  cv::Mat values = rgb;
  if (scale == Scale::Cell) {
    const int size = cell(w) | 1;
    rgb.convertTo(values, CV_32F);
    cv::blur(values, values, {size, size}, {-1, -1}, cv::BORDER_REPLICATE);
  }
  std::vector<float> out(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
  constexpr std::size_t n = FieldRow::kTerms;
  std::vector<float> row(stride() * n);
  for (int y = 0; y < h; ++y) {
    const float at =
        std::clamp((static_cast<float>(y) + 0.5f) * static_cast<float>(rows_) / static_cast<float>(h) - 0.5f,
                   0.0f, static_cast<float>(rows_ - 1));
    const std::size_t y0 = static_cast<std::size_t>(at),
                      y1 = std::min(y0 + 1, static_cast<std::size_t>(rows_ - 1));
    const float fy = at - static_cast<float>(y0);
    const float *a = terms(scale, static_cast<int>(y0)), *b = terms(scale, static_cast<int>(y1));
    for (std::size_t i = 0; i < row.size(); ++i) row[i] = a[i] + fy * (b[i] - a[i]);
    const std::size_t near_row = fy < 0.5f ? y0 : y1;
    float* to = out.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(w);
    for (int x = 0; x < w; ++x) {
      const float ax = std::clamp(
          (static_cast<float>(x) + 0.5f) * static_cast<float>(cols_) / static_cast<float>(w) - 0.5f, 0.0f,
          static_cast<float>(cols_ - 1));
      const std::size_t x0 = static_cast<std::size_t>(ax),
                        x1 = std::min(x0 + 1, static_cast<std::size_t>(cols_ - 1));
      const float fx = ax - static_cast<float>(x0);
      if (known(fx < 0.5f ? x0 : x1, near_row) == 0) {
        to[x] = std::numeric_limits<float>::infinity();
        continue;
      }
      float t[n];
      for (std::size_t k = 0; k < n; ++k) {
        const float *l = row.data() + k * stride() + x0, *r = row.data() + k * stride() + x1;
        t[k] = *l + fx * (*r - *l);
      }
      float c[3];
      if (scale == Scale::Cell) {
        const cv::Vec3f& v = values.at<cv::Vec3f>(y, x);
        for (int k = 0; k < 3; ++k) c[k] = v[k] - t[k];
      } else {
        const std::uint8_t* p = picture.at(x, y);
        for (int k = 0; k < 3; ++k) c[k] = static_cast<float>(p[k]) - t[k];
      }
      to[x] = darker_too_ && luma(c[0], c[1], c[2]) < 0 ? 0 : whitened_length(t + 3, c[0], c[1], c[2]);
    }
  }
  return out;
}

}  // namespace floatstage::matting
