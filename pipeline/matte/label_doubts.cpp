#include "pipeline/matte/label_doubts.h"

#include <algorithm>
#include <bit>

#include "core/text.h"

namespace floatstage::pipeline {
namespace {

constexpr std::size_t kHeard = 3;      // times the voxels that a word marks: who turns fewer was not heard
constexpr double kTaken = 0.1;         // of a label is left: words about others took it
constexpr double kMeets = 0.7;         // IoU with which labels from two frames must meet
constexpr double kLeastOfSum = 0.005;  // of the sum: less is lost
constexpr double kMerged = 0.6;        // of a label near another: space does not tell them apart

long pixels_of(const Image& labels, int label) {
  return static_cast<long>(
      std::count(labels.pixels.begin(), labels.pixels.end(), static_cast<std::uint8_t>(label)));
}

}  // namespace

LabelDoubts::LabelDoubts(const Rig& rig, std::vector<std::string> names, const LabelGivens& givens)
    : rig_(rig), names_(std::move(names)), givens_(givens) {}

void LabelDoubts::add(const std::string& why, const std::string& serial, int frame) {
  for (LabelDoubt& d : all_)
    if (d.why == why) {
      d.frames += doubted_[why].insert(frame).second;
      if (frame < d.frame) d.frame = frame, d.serial = serial;
      return;
    }
  doubted_[why].insert(frame);
  all_.push_back({why, serial, frame});
}

// The camera that shows least of a label, of those that show any of the sum.
int LabelDoubts::most_hidden(const LabelInstant& instant, int label) const {
  int camera = 0;
  double least = 2;
  for (std::size_t c = 0; c < instant.labels.size(); ++c) {
    if (instant.labels[c].empty()) continue;
    const long none = pixels_of(instant.labels[c], 0),
               all = static_cast<long>(instant.labels[c].pixels.size()) - none;
    const double share =
        all > 0 ? static_cast<double>(pixels_of(instant.labels[c], label)) / static_cast<double>(all) : 2;
    if (share < least) least = share, camera = static_cast<int>(c);
  }
  return camera;
}

// Cameras without which the hull was carved.
void LabelDoubts::disbelieved(const LabelInstant& instant) {
  const std::vector<RigCamera>& cameras = rig_.cameras;
  for (const auto& [camera, lacks] : instant.disbelieved) {
    const std::string& serial = cameras[static_cast<std::size_t>(camera)].serial;
    add(text("the matte of '", serial, "' has nobody where ",
             lacks.said_of
                 ? text("'", names_[static_cast<std::size_t>(lacks.label - 1)], "' is said to be in frame ",
                        lacks.frame, " of camera '", cameras[static_cast<std::size_t>(*lacks.said_of)].serial,
                        "'")
                 : text("most others show '", names_[static_cast<std::size_t>(lacks.label - 1)], "'"),
             "; labels were told apart without this camera; mend its mattes, by strokes or masks"),
        serial, instant.frame);
  }
}

void LabelDoubts::nowhere(const NowhereWord& word, int frame) {
  const std::vector<RigCamera>& cameras = rig_.cameras;
  std::string who;
  for (const int c : word.denied_by)
    who += text(who.empty() ? "'" : ", '", cameras[static_cast<std::size_t>(c)].serial, "'");
  add(text("what is said to be '", names_[static_cast<std::size_t>(word.label - 1)], "' at ", word.at.x(),
           ",", word.at.y(), " is nowhere in space, ",
           who.empty() ? "where silhouettes have nothing in common; mend the mattes of this frame"
                       : text("since the mattes of ", who, " have nobody there; mend those"),
           ", by strokes or masks"),
      cameras[static_cast<std::size_t>(word.camera)].serial, frame);
}

void LabelDoubts::merged(const LabelInstant& instant, const matting::LabelPalette& palette) {
  if (instant.merged <= kMerged) return;
  for (int a = 1; a <= static_cast<int>(names_.size()); ++a)
    for (int b = a + 1; b <= static_cast<int>(names_.size()); ++b)
      if (palette.alike(a, b) > kColorsAlike)
        add(text("'", names_[static_cast<std::size_t>(a - 1)], "' and '",
                 names_[static_cast<std::size_t>(b - 1)],
                 "' are one body to all cameras there and have the same colours, so that they may have been "
                 "exchanged from then on; give a mask or a click of each after it"),
            rig_.cameras[static_cast<std::size_t>(most_hidden(instant, a))].serial, instant.frame);
}

// Labels of which there is nothing; or nothing in space, and hardly more in pictures than what words mark.
void LabelDoubts::loss(const LabelInstant& instant) {
  const std::size_t labels = names_.size();
  std::vector<double> seen(labels + 1, 0), space = seen;  // the last ones: of all
  std::vector<double> unsaid(labels, 0);
  const std::map<int, LabelsAllowed>* said = said_of(givens_, instant.frame);
  for (std::size_t c = 0; c < instant.labels.size(); ++c) {
    const auto words =
        said ? said->find(static_cast<int>(c)) : std::map<int, LabelsAllowed>::const_iterator();
    const LabelsAllowed* may = said && words != said->end() ? &words->second : nullptr;
    for (std::size_t p = 0; p < instant.labels[c].pixels.size(); ++p) {
      const std::size_t l = instant.labels[c].pixels[p];
      if (l == 0) continue;
      const bool marked = may && std::popcount((*may)[p]) == 1;
      ++seen[l - 1], ++seen[labels];
      unsaid[l - 1] += !marked;
    }
  }
  for (std::size_t l = 0; l < instant.voxels.size(); ++l)
    space[l] = static_cast<double>(instant.voxels[l]), space[labels] += space[l];
  const auto lost = [&](const std::vector<double>& of, std::size_t l) {
    return of[labels] > 0 && of[l] < kLeastOfSum * of[labels];
  };
  for (std::size_t l = 0; l < labels; ++l)
    if (lost(seen, l) || (lost(space, l) && 2 * unsaid[l] < seen[l]))
      add(text("nothing is left of '", names_[l],
               "' in any camera; if that is wrong, give a mask or a click of it there"),
          rig_.cameras[static_cast<std::size_t>(most_hidden(instant, static_cast<int>(l) + 1))].serial,
          instant.frame);
}

// Words that turned nothing but what they mark.
void LabelDoubts::unheard(const LabelCorrection& correction, const std::vector<std::uint8_t>& voxels,
                          const LabelInstant& instant) {
  for (std::size_t l = 0; l < names_.size(); ++l) {
    if (!(correction.said >> l & 1)) continue;
    std::vector<std::size_t> marked = correction.seen[l];
    std::sort(marked.begin(), marked.end());
    marked.erase(std::unique(marked.begin(), marked.end()), marked.end());
    std::size_t turned = 0;
    for (std::size_t v = 0; v < voxels.size(); ++v) turned += correction.anew[v] && voxels[v] == l + 1;
    if (turned > kHeard * marked.size()) continue;
    int camera = 0;  // in which it was said
    for (const auto& [c, may] : givens_.at(instant.frame))
      if (std::find(may.begin(), may.end(), std::uint32_t{1} << l) != may.end()) camera = c;
    add(text(
            "what is said to be '", names_[l],
            "' has the colours of another label, and no more than what was marked became it; if it is right, "
            "give a click or a mask of each label in this frame"),
        rig_.cameras[static_cast<std::size_t>(camera)].serial, instant.frame);
  }
}

// Labels from which a word about another one took nearly all.
void LabelDoubts::taken(const LabelCorrection& correction, const std::vector<std::uint8_t>& voxels,
                        const LabelInstant& instant) {
  for (std::size_t l = 0; l < names_.size(); ++l) {
    if (!(correction.lost >> l & 1)) continue;
    const auto label = static_cast<std::uint8_t>(l + 1);
    const auto before = std::count(correction.carried.begin(), correction.carried.end(), label),
               now = std::count(voxels.begin(), voxels.end(), label);
    if (static_cast<double>(now) < kTaken * static_cast<double>(before))
      add(text("what was said of others took all of '", names_[l],
               "'; if it is there, give a click or a mask of it in this frame"),
          rig_.cameras[static_cast<std::size_t>(most_hidden(instant, label))].serial, instant.frame);
  }
}

void LabelDoubts::meeting(const LabelInstant& onward, const LabelInstant& backward) {
  for (int l = 1; l <= static_cast<int>(names_.size()); ++l) {
    double least = kMeets;
    int camera = -1;
    for (std::size_t c = 0; c < onward.labels.size(); ++c) {
      if (onward.labels[c].empty() || backward.labels[c].empty()) continue;
      long both = 0, either = 0;
      for (std::size_t p = 0; p < onward.labels[c].pixels.size(); ++p) {
        const bool a = onward.labels[c].pixels[p] == l, b = backward.labels[c].pixels[p] == l;
        both += a && b, either += a || b;
      }
      if (either > 0 && static_cast<double>(both) < least * static_cast<double>(either))
        least = static_cast<double>(both) / static_cast<double>(either), camera = static_cast<int>(c);
    }
    if (camera >= 0)
      add(text("'", names_[static_cast<std::size_t>(l - 1)],
               "' is not the same when it is followed from the frames given before and after; give a mask "
               "or a "
               "click of each label there"),
          rig_.cameras[static_cast<std::size_t>(camera)].serial, onward.frame);
  }
}

}  // namespace floatstage::pipeline
