#pragma once

#include <cstdint>
#include <optional>

namespace floatstage::capture {

/// Unwraps GVSP block ids, which number a camera's pictures: 16 bits from 1 to 65535 and then 1 again (0 is
/// no picture), or 64 bits that do not come round. Counts from 0 at the first.
class BlockIdUnwrapper {
 public:
  enum class Late {
    Overtaken,  ///< a little before the newest: its packets were overtaken by those of a later picture
    Restarted,  ///< far before it: the camera began again
  };
  /// Pictures that can be under way at once.
  explicit BlockIdUnwrapper(std::uint64_t in_flight = 16) : in_flight_(in_flight) {}

  /// How an id that unwrap() did not take is to be read.
  Late why_not(std::uint64_t id) const {
    const std::uint64_t back = id <= *last_id_ ? *last_id_ - id : *last_id_ + kRound - id;
    return back <= in_flight_ ? Late::Overtaken : Late::Restarted;
  }

  /// The picture's number; nothing when the id lies before the newest one: ask why_not().
  std::optional<std::uint64_t> unwrap(std::uint64_t id) {
    if (!last_id_) {
      last_id_ = id;
      return sequence_ = 0;
    }
    std::uint64_t step = 0;
    if (id > *last_id_) {
      if (*last_id_ <= in_flight_ && id <= kRound && kRound - id < in_flight_) return std::nullopt;
      step = id - *last_id_;
    } else if (*last_id_ <= kRound && id >= 1 && *last_id_ - id > kRound / 2) {
      step = id + kRound - *last_id_;
    } else {
      return std::nullopt;
    }
    last_id_ = id;
    return sequence_ += step;
  }

 private:
  static constexpr std::uint64_t kRound = 65535;  // ids of 16 bits

  std::uint64_t in_flight_;
  std::optional<std::uint64_t> last_id_;
  std::uint64_t sequence_ = 0;
};

}  // namespace floatstage::capture
