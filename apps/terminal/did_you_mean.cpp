#include "apps/terminal/did_you_mean.h"

#include <algorithm>
#include <cctype>

#include "core/text.h"

namespace floatstage::apps {
namespace {

std::string in_lower_case(std::string_view word) {
  std::string out(word);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

// Optimal string alignment: each swapped pair of neighbours is one slip.
std::size_t slips(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i)
    for (std::size_t j = 1; j <= b.size(); ++j) {
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

std::vector<std::string> parts_of(std::string_view word) {
  std::vector<std::string> parts(1);
  for (const char c : word) {
    if (c != '-')
      parts.back() += c;
    else if (!parts.back().empty())
      parts.emplace_back();
  }
  if (parts.back().empty()) parts.pop_back();
  return parts;
}

// "frames" and "frame" are one part; so are "size" and "size".
bool same_part(std::string_view a, std::string_view b) {
  constexpr std::size_t kShortest = 4;
  return std::min(a.size(), b.size()) >= kShortest && (a.starts_with(b) || b.starts_with(a));
}

std::size_t shared_parts(std::string_view a, std::string_view b) {
  std::size_t shared = 0;
  const std::vector<std::string> others = parts_of(b);
  for (const std::string& part : parts_of(a))
    shared += std::any_of(others.begin(), others.end(),
                          [&](const std::string& other) { return same_part(part, other); });
  return shared;
}

}  // namespace

std::string closest(std::string_view typed, const std::vector<std::string>& known) {
  const std::string word = in_lower_case(typed);
  const std::size_t letters = word.size() - std::min(word.find_first_not_of('-'), word.size());
  const std::size_t bearable = std::max<std::size_t>(1, letters / 3);
  std::string best;
  std::size_t fewest = 0;
  for (const std::string& candidate : known) {
    const std::size_t n = slips(word, in_lower_case(candidate));
    if (n > bearable && shared_parts(word, candidate) == 0) continue;
    if (!best.empty() && n >= fewest) continue;
    best = candidate;
    fewest = n;
  }
  return best;
}

std::string did_you_mean(std::string_view typed, const std::vector<std::string>& known) {
  const std::string word = closest(typed, known);
  return word.empty() ? "" : text("; did you mean '", word, "'?");
}

}  // namespace floatstage::apps
