#include "pipeline/onset_sync.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/statistics.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

constexpr std::size_t kMostOnsets = 200;
constexpr double kAmbiguous = 0.75;  // of the best shift's strength that no other may have

void keep_strongest(std::vector<Onset>& onsets) {
  std::sort(onsets.begin(), onsets.end(),
            [](const Onset& a, const Onset& b) { return a.strength > b.strength; });
  if (onsets.size() > kMostOnsets) onsets.resize(kMostOnsets);
  std::sort(onsets.begin(), onsets.end(),
            [](const Onset& a, const Onset& b) { return a.seconds < b.seconds; });
}

// Of an onset among others: one that is a hundred times as loud counts ten times.
double weight(const Onset& onset) { return std::sqrt(onset.strength); }

double weight_of(const std::vector<Onset>& onsets) {
  double sum = 0;
  for (const Onset& o : onsets) sum += weight(o);
  return sum;
}

// What two trains have in common when the second is moved back by `shift`: each onset meets one at most.
struct Meeting {
  double score = 0;  // of the strength of both, each of which is 1 in all
  std::vector<std::pair<double, double>> met;
};

Meeting meeting(const std::vector<Onset>& a, const std::vector<Onset>& b, double shift, double tolerance) {
  const double all_a = weight_of(a), all_b = weight_of(b);
  Meeting met;
  std::size_t j = 0;
  for (const Onset& one : a) {
    while (j < b.size() && b[j].seconds - shift < one.seconds - tolerance) ++j;
    std::size_t best = b.size();
    for (std::size_t k = j; k < b.size() && b[k].seconds - shift <= one.seconds + tolerance; ++k)
      if (best == b.size() || b[k].strength > b[best].strength) best = k;
    if (best == b.size()) continue;
    met.score += std::sqrt(weight(one) / all_a * weight(b[best]) / all_b);
    met.met.emplace_back(one.seconds, b[best].seconds);
    j = best + 1;
  }
  return met;
}

std::string shown(double seconds) { return text(std::round(1000 * seconds) / 1000, " s"); }

}  // namespace

bool PairShift::is_ambiguous() const { return second > kAmbiguous * score; }

PairShift pair_shift(const std::vector<Onset>& a, const std::vector<Onset>& b, const OnsetMatch& how) {
  std::vector<std::pair<double, double>> tried;  // shift, score
  for (const Onset& one : a)
    for (const Onset& other : b) {
      const double shift = other.seconds - one.seconds;
      tried.emplace_back(shift, meeting(a, b, shift, how.tolerance).score);
    }
  PairShift found;
  double best = 0;
  for (const auto& [shift, score] : tried)
    if (score > found.score) found.score = score, best = shift;
  if (found.score <= 0) return found;
  for (const auto& [shift, score] : tried)
    if (std::abs(shift - best) > how.separation && score > found.second)
      found.second = score, found.second_shift = shift;
  found.met = meeting(a, b, best, how.tolerance).met;
  std::vector<double> shifts;
  for (const auto& [first, second] : found.met) shifts.push_back(second - first);
  found.shift.events = static_cast<int>(shifts.size());
  found.shift.seconds = median(shifts);
  double sum = 0;
  for (const double s : shifts) sum += (s - found.shift.seconds) * (s - found.shift.seconds);
  found.shift.spread = std::sqrt(sum / static_cast<double>(shifts.size()));
  return found;
}

Result<std::vector<OnsetShift>> shifts_of(const std::vector<std::vector<Onset>>& onsets,
                                          const std::vector<std::string>& names, const OnsetMatch& how) {
  const std::size_t n = onsets.size();
  for (std::size_t c = 0; c < n; ++c)
    if (onsets[c].empty())
      return fail(ErrorCode::NotFound,
                  text("camera '", names[c], "': there is no ", how.event,
                       " in its video; leave it out with --cameras, synchronise by another sign (--sync), or "
                       "cut the videos to begin together and leave --sync out"));
  std::vector<std::vector<PairShift>> pairs(n, std::vector<PairShift>(n));
  std::vector<double> agreement(n, 0);
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = a + 1; b < n; ++b) {
      PairShift& ab = pairs[a][b];
      ab = pair_shift(onsets[a], onsets[b], how);
      pairs[b][a] = ab;
      pairs[b][a].shift.seconds = -ab.shift.seconds, pairs[b][a].second_shift = -ab.second_shift;
      agreement[a] += ab.score, agreement[b] += ab.score;
    }
  const auto root = static_cast<std::size_t>(
      std::distance(agreement.begin(), std::max_element(agreement.begin(), agreement.end())));
  std::vector<OnsetShift> shifts(n);
  for (std::size_t c = 0; c < n; ++c) {
    if (c == root) continue;
    const PairShift& pair = pairs[root][c];
    if (pair.score <= 0)
      return fail(ErrorCode::BadData,
                  text("camera '", names[c], "': no ", how.event, " of camera '", names[root],
                       "' is in its video, too; leave it out with --cameras"));
    if (pair.is_ambiguous())
      return fail(ErrorCode::BadData,
                  text("camera '", names[c], "': could be ", shown(pair.shift.seconds), " or ",
                       shown(pair.second_shift), " behind camera '", names[root], "': its ", how.event,
                       "es are too much alike. Cut the videos so that they hold one ", how.event,
                       ", or several at uneven distances"));
    shifts[c] = pair.shift;
  }
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = a + 1; b < n; ++b) {
      if (a == root || b == root || pairs[a][b].score <= 0) continue;
      const double open = pairs[a][b].shift.seconds - (shifts[b].seconds - shifts[a].seconds);
      if (std::abs(open) <= how.closure || pairs[a][b].is_ambiguous()) continue;
      const std::size_t doubtful = agreement[a] < agreement[b] ? a : b, other = doubtful == a ? b : a;
      return fail(
          ErrorCode::BadData,
          text("camera '", names[doubtful], "': contradicts the others: by camera '", names[other],
               "' it is ", shown(std::abs(open)), " from where it is by camera '", names[root],
               "'; leave it out with --cameras, or cut the videos so that they hold the same ", how.events));
    }
  if (root != 0) shifts[root] = {0, shifts.front().events, shifts.front().spread};
  const double first = std::exchange(shifts.front(), OnsetShift{shifts.front().seconds}).seconds;
  for (OnsetShift& s : shifts) s.seconds -= first;
  return shifts;
}

std::vector<Onset> sound_onsets(std::vector<float> samples, int rate, double begin) {
  constexpr double kJump = 16;                    // 12 dB, of power
  constexpr std::size_t kBefore = 30, kNew = 60;  // ms
  constexpr float kFirst = 0.2F;                  // of the wave's height
  const auto block = static_cast<std::size_t>(std::max(rate / 1000, 1));
  const std::size_t blocks = samples.size() / block;
  if (blocks <= kBefore) return {};
  // Differences leave out rumble and wind.
  std::vector<float>& wave = samples;
  for (std::size_t i = wave.size() - 1; i > 0; --i) wave[i] -= wave[i - 1];
  wave[0] = 0;
  std::vector<double> power(blocks, 0);
  for (std::size_t k = 0; k < blocks; ++k)
    for (std::size_t i = 0; i < block; ++i) power[k] += wave[k * block + i] * wave[k * block + i];
  // What is always there: nothing that is not louder is an onset.
  const double usual = median(power) + 1e-8 * static_cast<double>(block);
  std::vector<Onset> onsets;
  double before = 0;
  for (std::size_t k = 0; k < kBefore; ++k) before += power[k];
  std::size_t quiet_from = 0;
  for (std::size_t k = kBefore; k < blocks; ++k) {
    const double level = std::max(before / kBefore, usual);
    if (k >= quiet_from && power[k] > kJump * level) {
      // Its loudest within 3 ms, and where the wave first comes near that.
      const std::size_t from = (k - 1) * block, to = std::min((k + 3) * block, wave.size());
      float height = 0;
      double loudest = 0;
      for (std::size_t i = k * block; i < to; ++i) height = std::max(height, std::abs(wave[i]));
      for (std::size_t j = k; j < std::min(k + 3, blocks); ++j) loudest = std::max(loudest, power[j]);
      std::size_t at = from;
      while (at + 1 < to && std::abs(wave[at]) < kFirst * height) ++at;
      onsets.push_back(
          {begin + static_cast<double>(at) / rate, std::sqrt(loudest / static_cast<double>(block))});
      quiet_from = k + kNew;
    }
    before += power[k] - power[k - kBefore];
  }
  keep_strongest(onsets);
  return onsets;
}

std::vector<Onset> brightness_onsets(const std::vector<double>& brightness,
                                     const std::vector<double>& times) {
  constexpr double kLeast = 4, kUsual = 6, kStays = 0.5;
  std::vector<double> changes;
  for (std::size_t i = 1; i < brightness.size(); ++i)
    changes.push_back(std::abs(brightness[i] - brightness[i - 1]));
  if (changes.empty()) return {};
  const double least = std::max(kLeast, kUsual * median(changes));
  std::vector<Onset> onsets;
  for (std::size_t i = 1; i < brightness.size(); ++i) {
    const double jump = brightness[i] - brightness[i - 1];
    if (jump <= least) continue;
    const double period = times[i] - times[i - 1];
    // A light that stays on fills the next picture; what this one lacks of it is the part before.
    const double full = i + 1 < brightness.size() ? brightness[i + 1] - brightness[i - 1] : 0;
    const bool stays = full > kStays * jump;
    const double within = stays ? std::clamp(1 - jump / std::max(full, jump), 0.0, 1.0) : 0.5;
    onsets.push_back({times[i] + within * period, std::max(jump, full)});
    while (i + 1 < brightness.size() && brightness[i + 1] > brightness[i]) ++i;
  }
  keep_strongest(onsets);
  return onsets;
}

}  // namespace floatstage::pipeline
