#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/result.h"

namespace floatstage::pipeline {

/// The beginning of something that several recorders noticed, by the recorder's own time.
struct Onset {
  double seconds = 0;
  double strength = 0;  ///< above 0; of one recorder comparable, of several not
};

struct OnsetMatch {
  double tolerance;  ///< s: onsets of one event may lie so far apart, by sound's way or by a picture's length
  double separation;          ///< s: shifts that are nearer than this are one
  double closure;             ///< s: how well three recorders' shifts must agree
  std::string event, events;  ///< "clap", "claps": for sentences
};

/// How much later than the first one's each recorder's clock is: what must be subtracted from its times.
struct OnsetShift {
  double seconds = 0;
  int events = 0;     ///< that it shares with the recorder it was measured against
  double spread = 0;  ///< s: of their shifts around `seconds`, the root of the mean square; 0 of a single one
};

/// What the onsets of two recorders alone say of the second's shift against the first.
struct PairShift {
  OnsetShift shift;
  double score = 0;                     ///< share of both trains' strength that meets under it; 0: none does
  double second = 0, second_shift = 0;  ///< of the next best other one
  std::vector<std::pair<double, double>> met = {};  ///< times of the onsets that met, of the first and second

  bool is_ambiguous() const;  ///< the next best explains nearly as much
};
PairShift pair_shift(const std::vector<Onset>& first, const std::vector<Onset>& second,
                     const OnsetMatch& how);

/// Shifts of recorders by their whole trains of onsets: each is measured against the one that agrees most
/// with all others, by the shift under which most of the strength of both meets (the correlation of the two
/// trains, whose onsets are points), then by the median of the onsets that met. `names`: for sentences, one a
/// recorder. Errors, each naming the recorder and what to do: NotFound for one without onsets; BadData where
/// none meet, where another shift explains nearly as much, or where three recorders contradict each other.
/// `docs/adr/0281-cameras-started-by-hand.md`
Result<std::vector<OnsetShift>> shifts_of(const std::vector<std::vector<Onset>>& onsets,
                                          const std::vector<std::string>& names, const OnsetMatch& how);

/// Onsets in sound, one channel: where its level, of a millisecond each, jumps by 12 dB over that of the 30
/// ms before. To the sample: where the wave first reaches a fifth of its height. The strongest 200.
std::vector<Onset> sound_onsets(std::vector<float> samples, int rate, double begin);

/// Onsets in the mean brightness (0 … 255) of pictures: where it jumps by more than 4 and six times its usual
/// change. Within a picture by how much of its light came already, where the light stays on; else in its
/// middle. `times`: when each picture's exposure began, s.
std::vector<Onset> brightness_onsets(const std::vector<double>& brightness, const std::vector<double>& times);

}  // namespace floatstage::pipeline
