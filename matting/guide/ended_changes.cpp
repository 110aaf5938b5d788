#include <algorithm>

#include <opencv2/imgproc.hpp>

#include "matting/guide/guided_matte.h"
#include "matting/image_mat.h"

namespace floatstage::matting {
namespace {

constexpr double kWorthNaming = 0.01;  // of the subject: by less, no matte is called worse (ADR 302)
constexpr double kLost = 0.3;          // of a piece, in one step: a body that another hides goes in a few

struct Piece {
  double faulty = 0, lost = 0;
  bool taken_back = false;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero(), at = Eigen::Vector2d::Zero();
  double nearest = -1;
};

double subject_of(const Image& matte) {
  return static_cast<double>(
      std::count_if(matte.pixels.begin(), matte.pixels.end(), [](std::uint8_t v) { return v >= 128; }));
}

// One side's pieces. `other` is 255 where somebody says the contrary.
std::vector<Piece> pieces_of(const cv::Mat& followed, bool subject, const Image& base, const Image& matte,
                             const cv::Mat& other) {
  cv::Mat numbers;
  const int count = cv::connectedComponents(followed, numbers, 8, CV_32S);
  std::vector<Piece> pieces(static_cast<std::size_t>(count));
  const auto each_lost = [&](const auto& visit) {
    for (int y = 0; y < base.height; ++y)
      for (int x = 0; x < base.width; ++x) {
        const int number = numbers.at<int>(y, x);
        if (number > 0) visit(x, y, pieces[static_cast<std::size_t>(number)]);
      }
  };
  const auto wrong = [&](const Image& image, int x, int y) { return (*image.at(x, y) >= 128) != subject; };
  each_lost([&](int x, int y, Piece& piece) {
    piece.taken_back = piece.taken_back || other.at<std::uint8_t>(y, x);
    piece.faulty += wrong(base, x, y);
    if (!wrong(base, x, y) || !wrong(matte, x, y)) return;
    ++piece.lost;
    piece.sum += Eigen::Vector2d(x + 0.5, y + 0.5);
  });
  each_lost([&](int x, int y, Piece& piece) {
    if (!wrong(base, x, y) || !wrong(matte, x, y)) return;
    const Eigen::Vector2d here(x + 0.5, y + 0.5);
    const double off = (here - piece.sum / piece.lost).norm();
    if (piece.nearest >= 0 && off >= piece.nearest) return;
    piece.nearest = off;
    piece.at = here;
  });
  return pieces;
}

}  // namespace

std::vector<EndedChange> ended_changes(const CarriedGuidance& carried, const Image& base, const Image& matte,
                                       const Image& said) {
  std::vector<EndedChange> ended;
  if (carried.followed.empty()) return ended;
  const double least = kWorthNaming * std::max(subject_of(base), subject_of(matte));
  for (const int side : {255, 0}) {
    const cv::Mat followed = as_mat(carried.followed) == side, other = as_mat(said) == 255 - side;
    for (const Piece& piece : pieces_of(followed, side == 255, base, matte, other))
      if (!piece.taken_back && piece.lost > least && piece.lost > kLost * piece.faulty)
        ended.push_back(
            {side == 255 ? MatteLabel::Foreground : MatteLabel::Background, piece.at, piece.lost});
  }
  std::stable_sort(ended.begin(), ended.end(),
                   [](const EndedChange& a, const EndedChange& b) { return a.area > b.area; });
  return ended;
}

}  // namespace floatstage::matting
