#include "tests/detail/synthesis_protocol.h"

#include <numeric>

#include <opencv2/imgproc.hpp>

#include "core/random.h"
#include "detail/photo_file.h"
#include "tests/support/real_data.h"

namespace floatstage::detail::test {
namespace {

cv::Mat matrix_of(const Image& image) {
  return {image.height, image.width, CV_8UC3, const_cast<std::uint8_t*>(image.pixels.data())};
}

Image image_of(const cv::Mat& matrix) {
  Image out(matrix.cols, matrix.rows, 3);
  cv::Mat to = matrix_of(out);
  matrix.convertTo(to, CV_8U);
  return out;
}

cv::Mat in_floats(const Image& image) {
  cv::Mat out;
  matrix_of(image).convertTo(out, CV_32F);
  return out;
}

// Moved by whole pixels to the left and up; what leaves on one side enters on the other.
cv::Mat moved(const cv::Mat& from, int dx, int dy) {
  cv::Mat around, out;
  cv::copyMakeBorder(from, around, 0, dy, 0, dx, cv::BORDER_WRAP);
  around(cv::Rect(dx, dy, from.cols, from.rows)).copyTo(out);
  return out;
}

Image shuffled(const Image& truth, int side) {
  const int columns = truth.width / side, count = columns * (truth.height / side);
  std::vector<int> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  Random random(7);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.next() % i]);
  Image out(truth.width, truth.height, 3);
  for (int t = 0; t < count; ++t) {
    const int from = order[static_cast<std::size_t>(t)];
    for (int y = 0; y < side; ++y)
      std::copy_n(truth.at(from % columns * side, from / columns * side + y), 3 * side,
                  out.at(t % columns * side, t / columns * side + y));
  }
  return out;
}

}  // namespace

bool SynthesisProtocol::is_in_child(int x, int y, int margin) const {
  for (const Region& c : children)
    if (x >= c.x0 - margin && x < c.x1 + margin && y >= c.y0 - margin && y < c.y1 + margin) return true;
  return false;
}

Image cut_out(const Image& image, const Region& r) {
  Image out(r.width(), r.height(), 3);
  for (int y = 0; y < out.height; ++y)
    std::copy_n(image.at(r.x0, r.y0 + y), static_cast<std::size_t>(3 * out.width), out.at(0, y));
  return out;
}

Image shrunk_by_means(const Image& image, int factor) {
  cv::Mat small;
  cv::resize(matrix_of(image), small, {image.width / factor, image.height / factor}, 0, 0, cv::INTER_AREA);
  return image_of(small);
}

Result<SynthesisProtocol> panda_protocol() {
  const Result<Image> photo = load_photo(real_data("detail/panda/panda.jpg"));
  if (!photo) return forward(photo);
  SynthesisProtocol out;
  out.truth = cut_out(*photo, {1000, 300, 3048, 2348});
  out.low = shrunk_by_means(out.truth, out.zoom);
  out.children = {{200, 200, 712, 712}, {300, 900, 812, 1412}, {1400, 300, 1912, 812}};
  return out;
}

std::vector<Variant> variants_of(const SynthesisProtocol& p) {
  const cv::Mat truth = in_floats(p.truth), low = in_floats(p.low);
  cv::Mat bicubic, lanczos, blurred;
  cv::resize(low, bicubic, truth.size(), 0, 0, cv::INTER_CUBIC);
  cv::resize(low, lanczos, truth.size(), 0, 0, cv::INTER_LANCZOS4);
  const cv::Mat detail = truth - bicubic;
  std::vector<Variant> out;
  out.push_back({"truth", p.truth});
  out.push_back({"moved by 1", image_of(moved(truth, 1, 1))});
  out.push_back({"moved by 4", image_of(moved(truth, 4, 4))});
  out.push_back({"borrowed", image_of(bicubic + moved(detail, 40, 24))});
  out.push_back({"bicubic", image_of(bicubic)});
  out.push_back({"lanczos", image_of(lanczos)});
  cv::GaussianBlur(bicubic, blurred, {}, 6);
  out.push_back({"unsharp", image_of(bicubic + 2.5 * (bicubic - blurred))});
  cv::Mat noise(truth.size(), CV_32FC3);
  cv::RNG(11).fill(noise, cv::RNG::NORMAL, 0, 14);
  out.push_back({"noise", image_of(bicubic + noise)});
  out.push_back({"shuffled", shuffled(p.truth, 32)});
  cv::Mat mean = cv::Mat::zeros(truth.size(), CV_32FC3);
  for (int i = 0; i < 8; ++i) mean += moved(detail, 24 + 7 * i, 11 * (i % 3)) / 8;
  out.push_back({"averaged", image_of(bicubic + mean)});
  return out;
}

}  // namespace floatstage::detail::test
