#include "capture/ffv1_slices.h"

#include <algorithm>
#include <cstring>

extern "C" {
#include <libavutil/crc.h>
}

namespace floatstage::capture {
namespace {

constexpr std::size_t kFooter = 8;   // 3 bytes of size, 1 of error status, 4 of CRC
constexpr std::size_t kHeader = 32;  // bytes, which hold any slice's header
constexpr std::uint8_t kLost = 2;    // error_status: uncorrectable
constexpr int kMostCells = 256;      // a side; there is no picture with as many

// RFC 9043, "default_state_transition".
constexpr std::array<std::uint8_t, 256> kTransitions = {
    0,   0,   0,   0,   0,   0,   0,   0,   20,  21,  22,  23,  24,  25,  26,  27,  28,  29,  30,  31,
    32,  33,  34,  35,  36,  37,  37,  38,  39,  40,  41,  42,  43,  44,  45,  46,  47,  48,  49,  50,
    51,  52,  53,  54,  55,  56,  56,  57,  58,  59,  60,  61,  62,  63,  64,  65,  66,  67,  68,  69,
    70,  71,  72,  73,  74,  75,  75,  76,  77,  78,  79,  80,  81,  82,  83,  84,  85,  86,  87,  88,
    89,  90,  91,  92,  93,  94,  94,  95,  96,  97,  98,  99,  100, 101, 102, 103, 104, 105, 106, 107,
    108, 109, 110, 111, 112, 113, 114, 114, 115, 116, 117, 118, 119, 120, 121, 122, 123, 124, 125, 126,
    127, 128, 129, 130, 131, 132, 133, 133, 134, 135, 136, 137, 138, 139, 140, 141, 142, 143, 144, 145,
    146, 147, 148, 149, 150, 151, 152, 152, 153, 154, 155, 156, 157, 158, 159, 160, 161, 162, 163, 164,
    165, 166, 167, 168, 169, 170, 171, 171, 172, 173, 174, 175, 176, 177, 178, 179, 180, 181, 182, 183,
    184, 185, 186, 187, 188, 189, 190, 190, 191, 192, 194, 194, 195, 196, 197, 198, 199, 200, 201, 202,
    202, 204, 205, 206, 207, 208, 209, 209, 210, 211, 212, 213, 215, 215, 216, 217, 218, 219, 220, 220,
    222, 223, 224, 225, 226, 227, 227, 229, 229, 230, 231, 232, 234, 234, 235, 236, 237, 238, 239, 240,
    241, 242, 243, 244, 245, 246, 247, 248, 248, 0,   0,   0,   0,   0,   0,   0};

// Reads what a range coder wrote (RFC 9043, 3.8.1): all symbols of one set of states. Beyond the end there
// are zeros.
class RangeReader {
 public:
  RangeReader(std::span<const std::uint8_t> bytes, const std::array<std::uint8_t, 256>& transitions)
      : bytes_(bytes), transitions_(transitions) {
    states_.fill(128);
    low_ = next() << 8;
    low_ += next();
  }

  bool bit() { return bit(states_[0]); }
  int number() { return number(/*is_signed=*/false); }
  int signed_number() { return number(/*is_signed=*/true); }
  /// A bit in the way of the symbols, with a state of its own.
  bool lone_bit() {
    std::uint8_t state = 128;
    return bit(state);
  }

 private:
  unsigned next() { return at_ < bytes_.size() ? bytes_[at_++] : 0U; }

  bool bit(std::uint8_t& state) {
    const unsigned ones = range_ * state >> 8;
    range_ -= ones;
    const bool is_one = low_ >= range_;
    if (is_one) {
      low_ -= range_;
      range_ = ones;
      state = transitions_[state];
    } else {
      state = static_cast<std::uint8_t>(256 - transitions_[(256U - state) & 255U]);
    }
    if (range_ < 0x100) {
      range_ <<= 8;
      low_ = (low_ << 8) + next();
    }
    return is_one;
  }

  int number(bool is_signed) {
    if (bit(states_[0])) return 0;
    constexpr unsigned kMostBits = 30;
    unsigned bits = 0;
    while (bits < kMostBits && bit(states_[1 + std::min(bits, 9U)])) ++bits;
    int value = 1;
    for (unsigned i = bits; i > 0; --i)
      value += value + static_cast<int>(bit(states_[22 + std::min(i - 1, 9U)]));
    return is_signed && bit(states_[11 + std::min(bits, 10U)]) ? -value : value;
  }

  std::span<const std::uint8_t> bytes_;
  const std::array<std::uint8_t, 256>& transitions_;
  std::array<std::uint8_t, 32> states_;
  std::size_t at_ = 0;
  unsigned low_ = 0, range_ = 0xFF00;
};

std::uint32_t crc_of(std::span<const std::uint8_t> bytes) {
  return av_crc(av_crc_get_table(AV_CRC_32_IEEE), 0, bytes.data(), bytes.size());
}

// The last slice of what is left of a picture, with its footer; empty where there is none.
template <class Byte>
std::span<Byte> last_slice(std::span<Byte> picture) {
  if (picture.size() < kFooter) return {};
  const std::uint8_t* footer = picture.data() + picture.size() - kFooter;
  const std::size_t size = (std::size_t{footer[0]} << 16 | std::size_t{footer[1]} << 8 | footer[2]) + kFooter;
  return size > picture.size() ? std::span<Byte>() : picture.last(size);
}

// Of a slice the header, and the footer that says so; returns how many bytes were written.
std::size_t write_header(std::span<const std::uint8_t> slice, std::uint8_t* to) {
  std::memmove(to, slice.data(), kHeader);
  std::uint8_t* footer = to + kHeader;
  footer[0] = footer[1] = 0;
  footer[2] = kHeader;
  footer[3] = kLost;
  const std::uint32_t crc = crc_of({to, kHeader + 4});
  for (int i = 0; i < 4; ++i) footer[4 + i] = static_cast<std::uint8_t>(crc >> 8 * i);
  return kHeader + kFooter;
}

}  // namespace

bool ffv1_intact(std::span<const std::uint8_t> picture) {
  if (picture.empty()) return false;
  while (!picture.empty()) {
    const std::span<const std::uint8_t> slice = last_slice(picture);
    if (slice.empty() || crc_of(slice) != 0) return false;
    picture = picture.first(picture.size() - slice.size());
  }
  return true;
}

std::optional<Ffv1Slices> Ffv1Slices::of(std::span<const std::uint8_t> configuration, int width, int height) {
  RangeReader reader(configuration, kTransitions);
  Ffv1Slices slices;
  slices.width_ = width;
  slices.height_ = height;
  slices.transitions_ = kTransitions;
  if (reader.number() != 3) return std::nullopt;  // version
  reader.number();                                // micro_version
  if (reader.number() > 1)                        // coder_type: with a table of its own
    for (std::size_t i = 1; i < slices.transitions_.size(); ++i)
      slices.transitions_[i] = static_cast<std::uint8_t>(slices.transitions_[i] + reader.signed_number());
  reader.number();  // colorspace_type
  reader.number();  // bits_per_raw_sample
  reader.bit();     // chroma_planes
  reader.number();  // log2_h_chroma_subsample
  reader.number();  // log2_v_chroma_subsample
  reader.bit();     // extra_plane
  slices.columns_ = reader.number() + 1;
  slices.rows_ = reader.number() + 1;
  if (slices.columns_ > kMostCells || slices.rows_ > kMostCells) return std::nullopt;
  return slices;
}

// Which cells of the grid a slice covers: "Slice Header".
std::optional<PixelBox> Ffv1Slices::cells_of(std::span<const std::uint8_t> slice, bool is_first) const {
  RangeReader reader(slice, transitions_);
  if (is_first && !reader.lone_bit()) return std::nullopt;  // no key picture
  PixelBox cells;
  cells.x = reader.number();
  cells.y = reader.number();
  cells.width = reader.number() + 1;
  cells.height = reader.number() + 1;
  if (cells.x >= columns_ || cells.y >= rows_ || cells.width > columns_ - cells.x ||
      cells.height > rows_ - cells.y)
    return std::nullopt;
  return cells;
}

// All slices in order; nothing where they do not cover each cell once.
std::optional<std::vector<Ffv1Slices::Slice>> Ffv1Slices::find(std::span<std::uint8_t> picture,
                                                               std::span<const PixelBox> boxes) const {
  std::vector<Slice> slices;
  while (!picture.empty()) {
    const std::span<std::uint8_t> bytes = last_slice(picture);
    if (bytes.empty()) return std::nullopt;
    slices.push_back({bytes});
    picture = picture.first(picture.size() - bytes.size());
  }
  std::reverse(slices.begin(), slices.end());
  std::vector<bool> covered(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), false);
  std::size_t count = 0;
  for (Slice& slice : slices) {
    const std::optional<PixelBox> cells = cells_of(slice.bytes, &slice == &slices.front());
    if (!cells) return std::nullopt;
    for (int y = cells->y; y < cells->y + cells->height; ++y)
      for (int x = cells->x; x < cells->x + cells->width; ++x, ++count) {
        auto cell = covered[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) +
                            static_cast<std::size_t>(x)];
        if (cell) return std::nullopt;
        cell = true;
      }
    const auto edge = [](int cell, int size, int cells_of_all) { return cell * size / cells_of_all; };
    const int left = edge(cells->x, width_, columns_), top = edge(cells->y, height_, rows_),
              right = edge(cells->x + cells->width, width_, columns_),
              bottom = edge(cells->y + cells->height, height_, rows_);
    // Where chroma is shared, that of a pixel at a slice's edge is in the slice beside it, too.
    slice.is_kept = std::any_of(boxes.begin(), boxes.end(), [&](const PixelBox& box) {
      return left <= box.x + box.width && right >= box.x && top <= box.y + box.height && bottom >= box.y;
    });
  }
  if (count != covered.size()) return std::nullopt;
  return slices;
}

std::size_t Ffv1Slices::keep(std::span<std::uint8_t> picture, std::span<const PixelBox> boxes) const {
  const std::optional<std::vector<Slice>> slices = find(picture, boxes);
  if (!slices) return 0;
  for (const Slice& slice : *slices)
    if (slice.is_kept && crc_of(slice.bytes) != 0) return 0;
  std::uint8_t* to = picture.data();
  for (const Slice& slice : *slices) {
    if (!slice.is_kept && slice.bytes.size() > kHeader + kFooter) {
      to += write_header(slice.bytes, to);
      continue;
    }
    std::memmove(to, slice.bytes.data(), slice.bytes.size());
    to += slice.bytes.size();
  }
  return static_cast<std::size_t>(to - picture.data());
}

}  // namespace floatstage::capture
