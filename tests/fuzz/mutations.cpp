#include "tests/fuzz/mutations.h"

#include <algorithm>
#include <iterator>

#include "core/random.h"

namespace floatstage {
namespace {

constexpr std::size_t kMostTruncations = 512;
constexpr std::size_t kMutations = 1024;

constexpr std::string_view kHostile[] = {"-1",
                                         "0",
                                         "nan",
                                         "inf",
                                         "1e999",
                                         "-0.0",
                                         "2147483648",
                                         "4294967295",
                                         "4294967296",
                                         "18446744073709551616",
                                         "99999999999999999999999",
                                         "",
                                         "\"",
                                         "[[[[",
                                         "{",
                                         "\xff\xfe",
                                         "\n",
                                         ","};

std::size_t truncations(std::size_t size) { return std::min(size, kMostTruncations); }

std::size_t below(Random& random, std::size_t bound) {
  return bound == 0 ? 0 : static_cast<std::size_t>(random.next() % bound);
}

bool digit(char c) { return (c >= '0' && c <= '9') || c == '.' || c == '-'; }

// Replaces the first number at or after a random place, or inserts at the end.
void replace_number(std::string& s, Random& random) {
  const auto begin =
      std::find_if(s.begin() + static_cast<std::ptrdiff_t>(below(random, s.size())), s.end(), digit);
  const auto end = std::find_if_not(begin, s.end(), digit);
  const std::string_view hostile = kHostile[below(random, std::size(kHostile))];
  s.replace(begin, end, hostile.begin(), hostile.end());
}

void mutate_once(std::string& s, Random& random) {
  if (s.empty()) return;
  const std::size_t at = below(random, s.size());
  const std::size_t length = 1 + below(random, std::min<std::size_t>(s.size() - at, 64));
  switch (below(random, 7)) {
    case 0:
      s[at] = static_cast<char>(s[at] ^ (1 << below(random, 8)));
      break;
    case 1:
      s[at] = "\0\xff\x7f\x80"[below(random, 4)];
      break;
    case 2:
      s.erase(at, length);
      break;
    case 3:
      s.insert(at, s.substr(at, length));
      break;
    case 4: {
      const std::string piece = s.substr(at, length);
      s.erase(at, length);
      s.insert(below(random, s.size() + 1), piece);
      break;
    }
    case 5:
      std::fill_n(s.begin() + static_cast<std::ptrdiff_t>(at), length, '\xff');
      break;
    default:
      replace_number(s, random);
      break;
  }
}

}  // namespace

std::size_t mutation_count(std::size_t size) { return truncations(size) + kMutations; }

std::string mutated(std::string_view seed, std::size_t index) {
  const std::size_t cuts = truncations(seed.size());
  if (index < cuts) return std::string(seed.substr(0, index * seed.size() / cuts));
  Random random(mix(seed.size()) + index);
  std::string damaged(seed);
  for (std::size_t rounds = 1 + below(random, 4); rounds > 0; --rounds) mutate_once(damaged, random);
  return damaged;
}

}  // namespace floatstage
