#pragma once

#include <cstdint>

namespace floatstage {

/// A small seeded generator (SplitMix64, Steele et al. 2014) whose sequence is the same on every machine,
/// unlike the distributions of <random>. Passed in by reference; never global.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next();
  double uniform();                         ///< [0, 1)
  double uniform(double low, double high);  ///< [low, high)
  double normal();                          ///< mean 0, standard deviation 1 (Box-Muller, two draws a call)

 private:
  std::uint64_t state_;
};

/// A well-mixed 64-bit hash of its argument: a random number addressed by coordinates instead of by order.
std::uint64_t mix(std::uint64_t value);

}  // namespace floatstage
