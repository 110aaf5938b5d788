#pragma once

#include <array>
#include <cstdint>

namespace floatstage::recon {

__extension__ typedef __int128 Int128;
__extension__ typedef unsigned __int128 UInt128;

/// A signed integer of 384 bits (two's complement, six limbs, least first): enough for every predicate of the
/// exact hull, whose largest is the product of two 175-bit numbers. No allocation; overflow cannot happen for
/// those.
class Wide {
 public:
  Wide() = default;
  Wide(Int128 value) {  // NOLINT(*-explicit-*)
    limbs_[0] = static_cast<std::uint64_t>(value);
    limbs_[1] = static_cast<std::uint64_t>(value >> 64);
    limbs_[2] = limbs_[3] = limbs_[4] = limbs_[5] = value < 0 ? ~std::uint64_t{0} : 0;
  }

  int sign() const {
    if (static_cast<std::int64_t>(limbs_[5]) < 0) return -1;
    for (const std::uint64_t limb : limbs_) {
      if (limb != 0) return 1;
    }
    return 0;
  }

  Wide operator-() const {
    Wide out;
    std::uint64_t carry = 1;
    for (int i = 0; i < kLimbs; ++i) {
      out.limbs_[i] = ~limbs_[i] + carry;
      carry = carry != 0 && out.limbs_[i] == 0;
    }
    return out;
  }

  Wide operator+(const Wide& o) const {
    Wide out;
    UInt128 carry = 0;
    for (int i = 0; i < kLimbs; ++i) {
      carry += static_cast<UInt128>(limbs_[i]) + o.limbs_[i];
      out.limbs_[i] = static_cast<std::uint64_t>(carry);
      carry >>= 64;
    }
    return out;
  }

  Wide operator-(const Wide& o) const { return *this + (-o); }

  Wide operator*(const Wide& o) const {
    if (static_cast<std::int64_t>(limbs_[5]) < 0) return -((-*this) * o);
    if (static_cast<std::int64_t>(o.limbs_[5]) < 0) return -(*this * (-o));
    Wide out;
    for (int i = 0; i < kLimbs; ++i) {
      if (limbs_[i] == 0) continue;
      UInt128 carry = 0;
      for (int k = 0; i + k < kLimbs; ++k) {
        carry += static_cast<UInt128>(limbs_[i]) * o.limbs_[k] + out.limbs_[i + k];
        out.limbs_[i + k] = static_cast<std::uint64_t>(carry);
        carry >>= 64;
      }
    }
    return out;
  }

 private:
  static constexpr int kLimbs = 6;
  std::array<std::uint64_t, kLimbs> limbs_{};
};

inline int sign_of(Int128 value) { return (value > 0) - (value < 0); }

}  // namespace floatstage::recon
