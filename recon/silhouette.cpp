// Method:  the iso-line of a matte at half opacity, walked along pixel edges
// Paper:   marching squares: W. E. Lorensen, H. E. Cline, "Marching cubes", 1987, in two dimensions
// Differs: foreground connects over sides only, so that
//          outlines are simple and disjoint
// ADR:     none; docs/algorithms/visual-hull.md, section 1

#include "recon/silhouette.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace floatstage::recon {
namespace {

constexpr double kIso = 127.5;
// Points stay off the pixel centres, so that two lines through one saddle keep a gap of at least 0.07 px.
constexpr double kNearest = 0.05;

/// The matte, thresholded, one bit a pixel, with a frame of one pixel around it.
class BitPicture {
 public:
  BitPicture(const Matte& matte, std::vector<std::uint64_t>& storage)
      : words_((static_cast<std::size_t>(matte.width) + 2 + 63) / 64), height_(matte.height), bits_(storage) {
    storage.assign(words_ * (static_cast<std::size_t>(matte.height) + 2), 0);
    for (int y = 0; y < matte.height; ++y) pack_row(matte.row(y), matte.width, &bits_[words_ * (y + 1)]);
  }

  /// Pixel (x, y) of the picture; -1 and the size are the frame.
  bool at(int x, int y) const {
    const std::size_t column = static_cast<std::size_t>(x + 1);
    return (bits_[words_ * static_cast<std::size_t>(y + 1) + column / 64] >> (column % 64)) & 1U;
  }
  std::size_t words() const { return words_; }
  const std::uint64_t* row(int y) const { return &bits_[words_ * static_cast<std::size_t>(y + 1)]; }

  void fill_frame(int width) {
    auto set = [&](int x, int y) {
      const std::size_t column = static_cast<std::size_t>(x + 1);
      bits_[words_ * static_cast<std::size_t>(y + 1) + column / 64] |= std::uint64_t{1} << (column % 64);
    };
    for (int x = -1; x <= width; ++x) {
      set(x, -1);
      set(x, height_);
    }
    for (int y = 0; y < height_; ++y) {
      set(-1, y);
      set(width, y);
    }
  }

 private:
  /// The top bits (alpha >= 128) of sixteen bytes.
  static std::uint64_t top_bits(const std::uint8_t* bytes) {
#if defined(__SSE2__)
    return static_cast<std::uint64_t>(
        _mm_movemask_epi8(_mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes))));
#else
    std::uint64_t out = 0;
    for (int half = 0; half < 2; ++half) {
      std::uint64_t eight;
      std::memcpy(&eight, bytes + 8 * half, 8);
      // A multiplication gathers the eight bits.
      out |= (((eight >> 7) & 0x0101010101010101ULL) * 0x0102040810204080ULL >> 56) << (8 * half);
    }
    return out;
#endif
  }

  /// Pixel x becomes bit x + 1.
  void pack_row(const std::uint8_t* row, int width, std::uint64_t* out) const {
    std::uint64_t carry = 0;
    std::size_t word = 0;
    for (int x = 0; x < width; x += 64, ++word) {
      std::uint64_t bits = 0;
      if (x + 64 <= width) {
        for (int k = 0; k < 4; ++k) bits |= top_bits(row + x + 16 * k) << (16 * k);
      } else {
        for (int k = x; k < width; ++k) bits |= static_cast<std::uint64_t>(row[k] >> 7) << (k - x);
      }
      out[word] = bits << 1 | carry;
      carry = bits >> 63;
    }
    if (word < words_) out[word] = carry;
  }

  std::size_t words_;
  int height_;
  std::vector<std::uint64_t>& bits_;
};

struct Step {
  int dx, dy;
};
constexpr Step kSteps[4] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};  // turning right on the screen

double alpha_at(const Matte& matte, int x, int y, bool beyond) {
  if (x < 0 || y < 0 || x >= matte.width || y >= matte.height) return beyond ? 255 : 0;
  return matte.row(y)[x];
}

Eigen::Vector2d crossing(const Matte& matte, int fx, int fy, int bx, int by, bool beyond) {
  const auto outside = [&](int x, int y) { return x < 0 || y < 0 || x >= matte.width || y >= matte.height; };
  double t = 0.5;
  if (!outside(fx, fy) && !outside(bx, by)) {
    const double inside = alpha_at(matte, fx, fy, beyond), other = alpha_at(matte, bx, by, beyond);
    t = std::clamp((inside - kIso) / (inside - other), kNearest, 1 - kNearest);
  }
  return {fx + 0.5 + t * (bx - fx), fy + 0.5 + t * (by - fy)};
}

bool touches_border(const BitPicture& bits, int width, int height) {
  for (int x = 0; x < width; ++x) {
    if (bits.at(x, 0) || bits.at(x, height - 1)) return true;
  }
  for (int y = 0; y < height; ++y) {
    if (bits.at(0, y) || bits.at(width - 1, y)) return true;
  }
  return false;
}

bool any_subject(const std::vector<std::uint64_t>& bits) {
  return std::any_of(bits.begin(), bits.end(), [](std::uint64_t word) { return word != 0; });
}

}  // namespace

void trace_outline(const Matte& matte, bool unknown_beyond, SilhouetteScratch& scratch, Silhouette& out) {
  out.clear();
  if (matte.empty() || matte.width <= 0 || matte.height <= 0) return;
  BitPicture bits(matte, scratch.bits);
  out.beyond_counts =
      unknown_beyond || !any_subject(scratch.bits) || touches_border(bits, matte.width, matte.height);
  if (out.beyond_counts) bits.fill_frame(matte.width);
  scratch.visited.assign(scratch.bits.size(), 0);
  const auto visited = [&](int x, int y) -> std::pair<std::uint64_t&, std::uint64_t> {
    const std::size_t column = static_cast<std::size_t>(x + 1);
    return {scratch.visited[bits.words() * static_cast<std::size_t>(y + 1) + column / 64],
            std::uint64_t{1} << (column % 64)};
  };

  // Walks the pixel edges with the subject on the right, from the west edge of pixel (x, y) upwards.
  const auto walk = [&](int x0, int y0) {
    out.starts.push_back(static_cast<int>(out.points.size()));
    int cx = x0, cy = y0 + 1, direction = 3;
    do {
      // The pixel edge from lattice corner (cx, cy) in `direction`: subject pixel right of it, background
      // left.
      const Step step = kSteps[direction], right = kSteps[(direction + 1) % 4];
      const int fx = cx + (step.dx + right.dx - 1) / 2, fy = cy + (step.dy + right.dy - 1) / 2;
      const int bx = fx - right.dx, by = fy - right.dy;
      if (direction == 3) {
        auto [word, bit] = visited(fx, fy);
        word |= bit;
      }
      out.points.push_back(crossing(matte, fx, fy, bx, by, out.beyond_counts));
      cx += step.dx;
      cy += step.dy;
      // Foreground over corners is not connected: the right turn is tried first.
      if (!bits.at(fx + step.dx, fy + step.dy)) {
        direction = (direction + 1) % 4;
      } else if (bits.at(bx + step.dx, by + step.dy)) {
        direction = (direction + 3) % 4;
      }
    } while (cx != x0 || cy != y0 + 1 || direction != 3);
  };

  for (int y = 0; y < matte.height; ++y) {
    const std::uint64_t* row = bits.row(y);
    std::uint64_t carry = out.beyond_counts ? 1 : 0;  // the frame's left pixel has no edge of its own
    for (std::size_t w = 0; w < bits.words(); ++w) {
      std::uint64_t starts = row[w] & ~((row[w] << 1) | carry);
      if (w == 0) starts &= ~std::uint64_t{1};
      carry = row[w] >> 63;
      for (; starts != 0; starts &= starts - 1) {
        const int x = static_cast<int>(w * 64) + std::countr_zero(starts) - 1;
        auto [word, bit] = visited(x, y);
        if ((word & bit) == 0) walk(x, y);
      }
    }
  }
  out.starts.push_back(static_cast<int>(out.points.size()));
}

void drop_specks(double smallest, Silhouette& outline) {
  std::size_t kept = 0, polygons = 0;
  for (int k = 0; k < outline.polygons(); ++k) {
    const int begin = outline.starts[k], end = outline.starts[k + 1];
    double twice = 0;
    for (int i = begin; i < end; ++i) {
      const Eigen::Vector2d &p = outline.points[i], &q = outline.points[i + 1 < end ? i + 1 : begin];
      twice += p.x() * q.y() - p.y() * q.x();
    }
    if (std::abs(twice) < 2 * smallest) continue;
    outline.starts[polygons++] = static_cast<int>(kept);
    for (int i = begin; i < end; ++i) outline.points[kept++] = outline.points[i];
  }
  outline.points.resize(kept);
  outline.starts.resize(polygons + 1);
  outline.starts[polygons] = static_cast<int>(kept);
}

double enclosed_area(const Silhouette& outline) {
  double twice = 0;
  for (int k = 0; k < outline.polygons(); ++k) {
    for (int i = outline.starts[k], end = outline.starts[k + 1]; i < end; ++i) {
      const Eigen::Vector2d &p = outline.points[i],
                            &q = outline.points[i + 1 < end ? i + 1 : outline.starts[k]];
      twice += p.x() * q.y() - p.y() * q.x();
    }
  }
  return twice / 2;
}

}  // namespace floatstage::recon
