#include "studio/page/preview.h"

#include <algorithm>
#include <chrono>

#include "core/jpeg.h"

namespace floatstage::studio {
namespace {

constexpr int kWidth = 320;
constexpr int kQuality = 70;

// Means of k×k pixels of `channels` bytes.
Image shrunk(const std::uint8_t* pixels, std::size_t stride, int width, int height, int channels, int k) {
  Image small(std::max(1, width / k), std::max(1, height / k), channels);
  std::vector<std::uint32_t> sums(static_cast<std::size_t>(small.width) * static_cast<std::size_t>(channels));
  const int across = std::min(k, width), down = std::min(k, height);
  for (int y = 0; y < small.height; ++y) {
    std::fill(sums.begin(), sums.end(), 0);
    for (int dy = 0; dy < down; ++dy) {
      const std::uint8_t* row = pixels + static_cast<std::size_t>(y * k + dy) * stride;
      for (int x = 0; x < small.width; ++x)
        for (int dx = 0; dx < across; ++dx)
          for (int c = 0; c < channels; ++c)
            sums[static_cast<std::size_t>(x * channels + c)] += row[(x * k + dx) * channels + c];
    }
    for (std::size_t i = 0; i < sums.size(); ++i)
      small.pixels[static_cast<std::size_t>(y) * sums.size() + i] =
          static_cast<std::uint8_t>(sums[i] / static_cast<std::uint32_t>(across * down));
  }
  return small;
}

Image as_rgb(const Image& grey) {
  Image rgb(grey.width, grey.height, 3);
  for (std::size_t i = 0; i < grey.pixels.size(); ++i)
    std::fill_n(rgb.pixels.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, grey.pixels[i]);
  return rgb;
}

}  // namespace

Result<Image> preview_picture(const Frame& frame, int most_width) {
  const ImageLayout& l = frame.layout;
  const int k = std::max(1, (l.width + most_width - 1) / most_width);
  const bool grey = l.format == PixelFormat::Gray8;
  if (!frame.empty() && (grey || l.format == PixelFormat::Rgb8)) {
    Image small = shrunk(reinterpret_cast<const std::uint8_t*>(frame.pixels.get()), l.stride, l.width,
                         l.height, grey ? 1 : 3, k);
    return grey ? as_rgb(small) : small;
  }
  const Result<Image> whole = to_rgb(frame);
  if (!whole) return forward(whole);
  return shrunk(whole->pixels.data(), static_cast<std::size_t>(whole->width) * 3, whole->width, whole->height,
                3, k);
}

PreviewFeed::PreviewFeed(std::size_t cameras, double per_second, Sink sink)
    : per_second_(per_second), sink_(std::move(sink)) {
  for (std::size_t i = 0; i < cameras; ++i) slots_.push_back(std::make_unique<Slot>());
  thread_ = std::thread([this] { run(); });
}

PreviewFeed::~PreviewFeed() {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void PreviewFeed::offer(const Frame& frame) {
  if (!wanted_) return;
  Slot& slot = *slots_[static_cast<std::size_t>(frame.info.camera)];
  std::lock_guard lock(slot.mutex);
  if (std::exchange(slot.asked, false)) slot.frame = frame;
}

void PreviewFeed::make(std::size_t camera) {
  Slot& slot = *slots_[camera];
  Frame frame;
  {
    std::lock_guard lock(slot.mutex);
    frame = std::exchange(slot.frame, {});
    slot.asked = true;
  }
  if (frame.empty()) return;
  const Result<Image> small = preview_picture(frame, kWidth);
  if (small)
    sink_(static_cast<int>(camera), std::make_shared<const std::string>(encode_jpeg(*small, kQuality)));
}

void PreviewFeed::run() {
  const auto period = std::chrono::duration<double>(1 / per_second_);
  std::unique_lock lock(mutex_);
  while (!wake_.wait_for(lock, period, [&] { return stopping_; })) {
    if (!wanted_) continue;
    lock.unlock();
    for (std::size_t i = 0; i < slots_.size(); ++i) make(i);
    lock.lock();
  }
}

}  // namespace floatstage::studio
