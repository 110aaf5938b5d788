#include "matting/guide/guided_matte.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

#include "core/text.h"
#include "matting/closed_form.h"
#include "matting/guide/stroke_region.h"
#include "matting/image_mat.h"

namespace floatstage::matting {
namespace {

constexpr int kBand = 3;    // px on either side of a new outline that closed form solves …
constexpr int kApron = 24;  // … in a picture that reaches so far beyond what changed

// 255 within `margin` of where the two sides meet.
Image rim_of(const Image& sides, int margin) {
  cv::Mat high, low;
  const cv::Mat around = cv::getStructuringElement(cv::MORPH_RECT, {2 * margin + 1, 2 * margin + 1});
  cv::dilate(as_mat(sides), high, around);
  cv::erode(as_mat(sides), low, around);
  Image out(sides.width, sides.height, 1);
  as_mat(out).setTo(255, high != low);
  return out;
}

struct State {
  Image matte, sides, said;
  Image turned;  // 255 where a side is another one than before the first stroke
  int step = 1;  // of the least exact region
};

int margin_of(const State& state) { return kBand + (state.step > 1 ? state.step : 0); }

// The new outline's edge.
Result<void> solve_edges(const Image& picture, State& state) {
  cv::Rect box = cv::boundingRect(as_mat(state.turned));
  if (box.empty()) return {};
  const int margin = margin_of(state);
  box = cv::Rect(box.x - kApron, box.y - kApron, box.width + 2 * kApron, box.height + 2 * kApron) &
        cv::Rect(0, 0, picture.width, picture.height);
  if (box.width < 3 || box.height < 3) return {};
  const Image sides = part_of(state.sides, box), said = part_of(state.said, box),
              near = grown(part_of(state.turned, box), margin), rim = rim_of(sides, margin);
  const Image matte = part_of(state.matte, box);
  Image known = sides;
  bool unknown = false, certain = false;
  for (std::size_t p = 0; p < known.pixels.size(); ++p) {
    if (said.pixels[p] != 128)
      known.pixels[p] = said.pixels[p];
    else if ((near.pixels[p] && rim.pixels[p]) || (matte.pixels[p] > 12 && matte.pixels[p] < 243))
      known.pixels[p] = 128;
    unknown = unknown || known.pixels[p] == 128;
    certain = certain || known.pixels[p] != 128;
  }
  if (!unknown || !certain) return {};
  ClosedFormOptions options;
  options.prior = key_refinement().hold;
  const Result<Image> solved = closed_form_matte(part_of(picture, box), known, options, matte);
  if (!solved) return forward(solved);
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x)
      if (*near.at(x, y) && *known.at(x, y) == 128) *state.matte.at(box.x + x, box.y + y) = *solved->at(x, y);
  return {};
}

// Turns what a print turns; whether any pixel is another one for it.
bool turn(const Image& picture, const SideColors& colors, const Image& print, std::uint8_t side,
          const Image* within, State& state) {
  const StrokeRegion region = stroke_region({picture, state.sides, state.said, colors}, print, side);
  bool acted = false;
  for (std::size_t p = 0; p < print.pixels.size(); ++p) {
    const bool turns = region.turned.pixels[p] && (!within || region.whole || within->pixels[p]);
    if (!turns && (within || !print.pixels[p])) continue;
    acted = acted || state.matte.pixels[p] != side;
    if (state.sides.pixels[p] != side) state.turned.pixels[p] = 255;
    state.sides.pixels[p] = state.matte.pixels[p] = side;
  }
  if (acted) state.step = std::max(state.step, region.step);
  return acted;
}

StrokeEffect apply(const Image& picture, const SideColors& colors, const MatteStroke& stroke,
                   const Image& fixed, State& state) {
  const std::uint8_t side = stroke.label == MatteLabel::Foreground ? 255 : 0;
  Image print(picture.width, picture.height, 1, 128);
  paint_strokes({stroke}, 1, print);
  bool outside = true;
  for (std::size_t p = 0; p < print.pixels.size(); ++p) {
    const bool marked = print.pixels[p] != 128 && (fixed.empty() || fixed.pixels[p] == 128);
    outside = outside && print.pixels[p] == 128;
    print.pixels[p] = marked ? 255 : 0;
    if (marked) state.said.pixels[p] = side;
  }
  if (outside) return StrokeEffect::Outside;
  // Beside what an earlier stroke has turned, it says where the edge is not.
  const Image edges = grown(state.turned, margin_of(state));
  bool acted = turn(picture, colors, print, side, nullptr, state);
  for (std::size_t p = 0; p < print.pixels.size() && !acted; ++p) acted = print.pixels[p] && edges.pixels[p];
  return acted ? StrokeEffect::Acted : StrokeEffect::Already;
}

void apply(const Image& picture, const SideColors& colors, const CarriedGuidance& carried, State& state) {
  for (const int side : {255, 0}) {
    Image print(picture.width, picture.height, 1);
    for (std::size_t p = 0; p < print.pixels.size(); ++p)
      print.pixels[p] = carried.said.pixels[p] == side && state.said.pixels[p] == 128 ? 255 : 0;
    turn(picture, colors, print, static_cast<std::uint8_t>(side), &carried.within, state);
  }
}

}  // namespace

Result<GuidedMatte> guided_matte(const Image& picture, const Image& matte,
                                 const std::vector<MatteStroke>& strokes, const Image& fixed,
                                 const CarriedGuidance& carried) {
  const auto fits = [&](const Image& map) {
    return map.channels == 1 && map.width == picture.width && map.height == picture.height;
  };
  if (picture.channels != 3 || picture.width < 3 || picture.height < 3 || !fits(matte) ||
      (!fixed.empty() && !fits(fixed)) ||
      (!carried.said.empty() && !(fits(carried.said) && fits(carried.within))))
    return fail(ErrorCode::InvalidArgument,
                text("a matte is guided with a picture of its size in RGB, 3x3 at least, not ", picture.width,
                     "x", picture.height, " with ", picture.channels, " channels"));
  State state{matte, matte, fixed.empty() ? Image(matte.width, matte.height, 1, 128) : fixed,
              Image(matte.width, matte.height, 1)};
  for (std::uint8_t& v : state.sides.pixels) v = v >= 128 ? 255 : 0;
  const SideColors colors(picture, state.sides);
  GuidedMatte out;
  if (!carried.said.empty()) apply(picture, colors, carried, state);
  for (const MatteStroke& stroke : strokes)
    out.effects.push_back(apply(picture, colors, stroke, fixed, state));
  if (Result<void> ok = solve_edges(picture, state); !ok) return forward(ok);
  out.matte = std::move(state.matte);
  return out;
}

}  // namespace floatstage::matting
