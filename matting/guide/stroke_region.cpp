// Method:  a stroke turns over what hangs together with it: a minimum cut against the matte that stands
// Paper:   after Y. Boykov, M.-P. Jolly, "Interactive graph cuts", 2001
// Differs: only pixels on the wrong side can turn, the matte that stands is the prior, and a region must bear
//          itself out
// ADR:     0302

#include "matting/guide/stroke_region.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <opencv2/imgproc.hpp>

#include "matting/frame_cut.h"
#include "matting/image_mat.h"

namespace floatstage::matting {
namespace {

constexpr double kReach = 0.15;     // of the longer side: how far from the stroke a region is looked for
constexpr double kWindow = 40'000;  // working pixels of the window at most
constexpr float kColor = 4;         // log-odds by colour at most
constexpr float kStay = 1.0f;       // log-odds that the matte that stands is worth
constexpr float kCertain = 1000;    // of what somebody said
constexpr double kSmooth = 3;
constexpr int kTurns = 3;         // of colours and cut
constexpr double kFree = 0.004;   // of the subject: what turns as a whole whatever its colours
constexpr double kHole = 0.03;    // of the subject: a hole that is marked in its middle turns
constexpr double kBorne = 0.5;    // of a region's border has contrast, or the region is not believed
constexpr float kThicker = 1.5f;  // times as thick as where the stroke lies: what turns with it
constexpr double kOneKind = 0.8;  // of a piece has the colours of what marks it
constexpr std::size_t kSamples = 40'000;

struct Piece {  // pixels of the other side that hang together with the stroke's wrong ones
  Image mask;   // 255
  cv::Rect box;
  long area = 0;
  bool at_border = false, kept = false, largest = false;  // kept: somebody said that part of it is right
};

long area_of(const Image& mask) { return cv::countNonZero(as_mat(mask)); }

// The pieces that wrong pixels lie in, as one.
Piece piece_of(const StrokeScene& scene, const Image& wrong, std::uint8_t side) {
  const cv::Mat other = as_mat(scene.sides) != side;
  cv::Mat labels, stats, centres;
  const int count = cv::connectedComponentsWithStats(other, labels, stats, centres, 4, CV_32S);
  std::vector<std::uint8_t> hit(static_cast<std::size_t>(count));
  Piece piece{Image(wrong.width, wrong.height, 1), {}};
  for (int y = 0; y < wrong.height; ++y)
    for (int x = 0; x < wrong.width; ++x)
      if (*wrong.at(x, y)) hit[static_cast<std::size_t>(labels.at<int>(y, x))] = 1;
  int largest = 0;
  for (int i = 1; i < count; ++i)
    if (!largest || stats.at<int>(i, cv::CC_STAT_AREA) > stats.at<int>(largest, cv::CC_STAT_AREA))
      largest = i;
  for (int i = 1; i < count; ++i) {
    if (!hit[static_cast<std::size_t>(i)]) continue;
    const cv::Rect box(stats.at<int>(i, cv::CC_STAT_LEFT), stats.at<int>(i, cv::CC_STAT_TOP),
                       stats.at<int>(i, cv::CC_STAT_WIDTH), stats.at<int>(i, cv::CC_STAT_HEIGHT));
    piece.box |= box;
    piece.area += stats.at<int>(i, cv::CC_STAT_AREA);
    piece.at_border = piece.at_border || box.x == 0 || box.y == 0 || box.br().x == wrong.width ||
                      box.br().y == wrong.height;
    piece.largest = piece.largest || i == largest;
  }
  const std::uint8_t against = static_cast<std::uint8_t>(255 - side);
  for (int y = piece.box.y; y < piece.box.br().y; ++y)
    for (int x = piece.box.x; x < piece.box.br().x; ++x) {
      const int label = labels.at<int>(y, x);
      if (!label || !hit[static_cast<std::size_t>(label)]) continue;
      if (*scene.said.at(x, y) == against)
        piece.kept = true;
      else
        *piece.mask.at(x, y) = 255;
    }
  return piece;
}

// Whether wrong pixels lie in the middle of a piece.
bool in_the_middle(const Piece& piece, const Image& wrong) {
  cv::Mat depth, part;
  cv::copyMakeBorder(as_mat(piece.mask)(piece.box), part, 1, 1, 1, 1, cv::BORDER_CONSTANT, 0);
  cv::distanceTransform(part, depth, cv::DIST_L2, 3, CV_32F);
  double deepest = 0, there = 0;
  cv::minMaxLoc(depth, nullptr, &deepest);
  cv::minMaxLoc(depth(cv::Rect(1, 1, piece.box.width, piece.box.height)), nullptr, &there, nullptr, nullptr,
                as_mat(wrong)(piece.box));
  return 2 * there >= deepest;
}

// The window around a stroke, each pixel the mean of `step` by `step`.
struct Window {
  cv::Rect box;
  int step = 1;
  Image picture;
  std::vector<std::uint8_t> kind;  // as CutEvidence::asked; 3: what somebody said stays
  std::vector<std::uint8_t> sure;  // the stroke itself
  std::size_t size() const { return kind.size(); }
  const std::uint8_t* rgb(std::size_t p) const { return picture.pixels.data() + 3 * p; }
};

cv::Rect grown(const cv::Rect& box, int by, const Image& within) {
  return cv::Rect(box.x - by, box.y - by, box.width + 2 * by, box.height + 2 * by) &
         cv::Rect(0, 0, within.width, within.height);
}

Window window_of(const StrokeScene& scene, const Piece& piece, const Image& wrong, std::uint8_t side,
                 const cv::Rect& box) {
  Window out;
  out.step = std::max(1, static_cast<int>(std::ceil(std::sqrt(box.area() / kWindow))));
  const int nx = (box.width + out.step - 1) / out.step, ny = (box.height + out.step - 1) / out.step;
  out.box = box;
  out.picture = Image(nx, ny, 3);
  out.kind.assign(static_cast<std::size_t>(nx) * ny, 0);
  out.sure.assign(out.kind.size(), 0);
  for (int v = 0; v < ny; ++v)
    for (int u = 0; u < nx; ++u) {
      int sum[3] = {}, n = 0, open = 0, right = 0, mark = 0;
      for (int y = box.y + v * out.step; y < std::min(box.br().y, box.y + (v + 1) * out.step); ++y)
        for (int x = box.x + u * out.step; x < std::min(box.br().x, box.x + (u + 1) * out.step); ++x, ++n) {
          for (int c = 0; c < 3; ++c) sum[c] += scene.picture.at(x, y)[c];
          open += *piece.mask.at(x, y) != 0;
          right += *scene.sides.at(x, y) == side;
          mark += *wrong.at(x, y) != 0;
        }
      const std::size_t p = static_cast<std::size_t>(v) * nx + u;
      for (int c = 0; c < 3; ++c) out.picture.pixels[3 * p + c] = static_cast<std::uint8_t>(sum[c] / n);
      out.sure[p] = mark > 0;
      out.kind[p] = mark > 0 || 2 * open >= n ? 1 : 2 * right >= n ? 2 : 0;
    }
  return out;
}

// What of a region hangs together with the stroke.
Image joined(const Window& window, Image region) {
  cv::Mat labels;
  const int count = cv::connectedComponents(as_mat(region), labels, 4, CV_32S);
  const int* label = labels.ptr<int>();
  std::vector<std::uint8_t> hit(static_cast<std::size_t>(count));
  for (std::size_t p = 0; p < window.size(); ++p)
    if (window.sure[p]) hit[static_cast<std::size_t>(label[p])] = 1;
  for (std::size_t p = 0; p < window.size(); ++p)
    if (!hit[static_cast<std::size_t>(label[p])]) region.pixels[p] = 0;
  return region;
}

// Hair that a stick before the black wall touches is no stick: what is much thicker than the place of the
// stroke is something else.
Image without_thicker_parts(const Window& window, const Image& region) {
  cv::Mat padded, depth, from_core;
  cv::copyMakeBorder(as_mat(region), padded, 1, 1, 1, 1, cv::BORDER_CONSTANT, 0);
  cv::distanceTransform(padded, depth, cv::DIST_L2, 3, CV_32F);
  const auto at = [&](const cv::Mat& map, std::size_t p) {
    return map.at<float>(static_cast<int>(p) / region.width + 1, static_cast<int>(p) % region.width + 1);
  };
  float here = 1;
  for (std::size_t p = 0; p < window.size(); ++p)
    if (window.sure[p]) here = std::max(here, at(depth, p));
  const float reach = kThicker * here + 1;
  const cv::Mat thin = depth <= reach;
  cv::distanceTransform(thin, from_core, cv::DIST_L2, 3, CV_32F);
  Image out = region;
  for (std::size_t p = 0; p < window.size(); ++p)
    if (at(from_core, p) <= reach && !window.sure[p]) out.pixels[p] = 0;
  return out;
}

// What turns in the window: 255.
Image cut_window(const StrokeScene& scene, const Window& window, std::uint8_t side) {
  const ColorModel& frame = side ? scene.colors.background : scene.colors.subject;
  Image turned(window.picture.width, window.picture.height, 1);
  for (std::size_t p = 0; p < window.size(); ++p) turned.pixels[p] = window.sure[p] ? 255 : 0;
  for (int turn = 0; turn < kTurns; ++turn) {
    long marks = 0, others = 0;
    for (std::size_t p = 0; p < window.size(); ++p)
      (window.sure[p] ? marks : others) += turned.pixels[p] != 0;
    ColorModel mine, theirs;
    for (std::size_t p = 0; p < window.size(); ++p) {
      if (window.sure[p])
        mine.add(window.rgb(p), 1.0f / static_cast<float>(marks));
      else if (turned.pixels[p])
        mine.add(window.rgb(p), 1.0f / static_cast<float>(others));
      else if (window.kind[p] < 2)
        theirs.add(window.rgb(p));
    }
    mine.finish();
    theirs.finish();
    CutEvidence evidence{std::vector<float>(window.size()), window.kind, {}};
    for (std::size_t p = 0; p < window.size(); ++p) {
      const std::uint8_t* rgb = window.rgb(p);
      const float odds =
          std::log(2 * mine.likelihood(rgb) / (theirs.likelihood(rgb) + frame.likelihood(rgb)));
      evidence.odds[p] = window.sure[p] ? kCertain : std::clamp(odds, -kColor, kColor) - kStay;
    }
    Image cut = cut_frame(window.picture, evidence, kSmooth);
    for (std::size_t p = 0; p < window.size(); ++p) cut.pixels[p] = window.kind[p] == 1 ? cut.pixels[p] : 0;
    Image next = joined(window, std::move(cut));
    if (next == turned) break;
    turned = std::move(next);
  }
  return joined(window, without_thicker_parts(window, turned));
}

// Share of a region's border with what stays open that the picture has an edge at; beyond the window there is
// none.
double borne_out(const Window& window, const Image& turned) {
  const int w = turned.width, h = turned.height;
  double contrast = 0;
  long pairs = 0;
  const auto difference = [&](std::size_t p, std::size_t q) {
    double sum = 0;
    for (int c = 0; c < 3; ++c) sum += std::pow(window.rgb(p)[c] - window.rgb(q)[c], 2);
    return sum;
  };
  const auto each = [&](const auto& what) {
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        const std::size_t p = static_cast<std::size_t>(y) * w + x;
        if (x + 1 < w) what(p, p + 1);
        if (y + 1 < h) what(p, p + static_cast<std::size_t>(w));
      }
  };
  each([&](std::size_t p, std::size_t q) { contrast += difference(p, q), ++pairs; });
  const double beta = contrast > 0 ? static_cast<double>(pairs) / (2 * contrast) : 0;
  double border = 0, edge = 0;
  each([&](std::size_t p, std::size_t q) {
    if ((turned.pixels[p] != 0) == (turned.pixels[q] != 0)) return;
    if (window.kind[p] == 2 || window.kind[q] == 2) return;
    border += 1, edge += 1 - std::exp(-beta * difference(p, q));
  });
  return border > 0 ? edge / border : 1;
}

// Whether a piece has the colours of what marks it throughout.
bool of_one_kind(const Window& window, const Image& mask) {
  ColorModel mine, all;
  for (std::size_t p = 0; p < window.size(); ++p) {
    if (window.sure[p]) mine.add(window.rgb(p));
    if (mask.pixels[p]) all.add(window.rgb(p));
  }
  mine.finish();
  all.finish();
  long alike = 0, area = 0;
  for (std::size_t p = 0; p < window.size(); ++p)
    if (mask.pixels[p]) ++area, alike += 2 * mine.likelihood(window.rgb(p)) >= all.likelihood(window.rgb(p));
  return alike >= kOneKind * static_cast<double>(area);
}

// An island or a hole that is a thing of its own: its outline is in the picture, or it is of one kind. A
// person with a piece of floor is neither.
bool turns_as_a_whole(const StrokeScene& scene, const Piece& piece, const Image& wrong, std::uint8_t side,
                      long subject) {
  if (piece.kept) return false;
  const double share = static_cast<double>(piece.area) / static_cast<double>(std::max(1L, subject));
  if (share <= kFree) return true;
  const bool island = side == 0 && !piece.largest, hole = side == 255 && !piece.at_border && share <= kHole;
  if (!(island || hole) || !in_the_middle(piece, wrong)) return false;
  Window window = window_of(scene, piece, wrong, side, grown(piece.box, 4, wrong));
  Image mask(window.picture.width, window.picture.height, 1);
  for (std::size_t p = 0; p < window.size(); ++p) {
    mask.pixels[p] = window.kind[p] == 1 ? 255 : 0;
    window.kind[p] = window.kind[p] == 1 ? 1 : 0;  // its border to the other side counts
  }
  return borne_out(window, mask) >= kBorne || of_one_kind(window, mask);
}

}  // namespace

SideColors::SideColors(const Image& picture, const Image& sides) {
  const std::size_t stride = std::max<std::size_t>(1, sides.pixels.size() / kSamples);
  for (std::size_t p = 0; p < sides.pixels.size(); p += stride)
    (sides.pixels[p] ? subject : background).add(picture.pixels.data() + 3 * p);
  subject.finish();
  background.finish();
}

StrokeRegion stroke_region(const StrokeScene& scene, const Image& print, std::uint8_t side) {
  Image wrong(print.width, print.height, 1);
  bool any = false;
  for (std::size_t p = 0; p < print.pixels.size(); ++p)
    if (print.pixels[p] && scene.sides.pixels[p] != side) wrong.pixels[p] = 255, any = true;
  if (!any) return {std::move(wrong), 1, false};
  const long subject = area_of(scene.sides);
  const Piece piece = piece_of(scene, wrong, side);
  if (turns_as_a_whole(scene, piece, wrong, side, subject)) return {piece.mask, 1, true};
  const int reach = std::max(8, static_cast<int>(std::lround(kReach * std::max(wrong.width, wrong.height))));
  const Window window =
      window_of(scene, piece, wrong, side, grown(cv::boundingRect(as_mat(wrong)), reach, wrong));
  const Image turned = cut_window(scene, window, side);
  Image region = wrong;
  for (int y = window.box.y; y < window.box.br().y; ++y)
    for (int x = window.box.x; x < window.box.br().x; ++x)
      if (*piece.mask.at(x, y) &&
          *turned.at((x - window.box.x) / window.step, (y - window.box.y) / window.step))
        *region.at(x, y) = 255;
  const long most = std::max(area_of(wrong), static_cast<long>(kFree * static_cast<double>(subject)));
  if (area_of(region) <= most || borne_out(window, turned) >= kBorne)
    return {std::move(region), window.step, false};
  // Only what is nearest to the stroke.
  cv::Mat far, away = as_mat(wrong) == 0;
  cv::distanceTransform(away, far, cv::DIST_L2, 3, CV_32F);
  std::vector<long> at(256, 0);
  const auto ring = [&](std::size_t p) {
    return std::min<std::size_t>(255, static_cast<std::size_t>(far.ptr<float>()[p]));
  };
  for (std::size_t p = 0; p < region.pixels.size(); ++p)
    if (region.pixels[p]) ++at[ring(p)];
  std::size_t last = 0;
  for (long sum = at[0]; last + 1 < at.size() && sum + at[last + 1] <= most; ++last) sum += at[last + 1];
  for (std::size_t p = 0; p < region.pixels.size(); ++p)
    if (region.pixels[p] && !wrong.pixels[p] && ring(p) > last) region.pixels[p] = 0;
  return {std::move(region), window.step, false};
}

}  // namespace floatstage::matting
