#include "pipeline/matte/contradiction.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "core/file_presence.h"
#include "core/statistics.h"
#include "core/text.h"
#include "pipeline/matte/consistent_verdict.h"
#include "pipeline/matte/doubt_pictures.h"
#include "pipeline/matte/doubt_sheet.h"
#include "pipeline/matte/hull_cover.h"
#include "pipeline/matte/matte_how.h"
#include "pipeline/matte_record.h"

namespace floatstage::pipeline {
namespace {

constexpr double kMost = 0.5;     // of a matte, and of the cameras: a majority
constexpr double kDenied = 0.05;  // of a matte, in most cameras: as kDeniedInMost of consistent_verdict.cpp

struct Vote {
  int cameras = 0;
  std::map<std::string, double> denied;
  bool contradicts() const {
    return static_cast<double>(denied.size()) >= kMost * cameras && denied.size() > 1;
  }
  double typical() const {
    std::vector<double> shares;
    for (const auto& [serial, share] : denied) shares.push_back(share);
    return median(std::move(shares));
  }
};

/// The frames in which half of the cameras are denied more of their subject than `most` of so many.
struct Denial {
  int frames = 0, worst = 0;
  Vote vote;  // of the worst
};

template <class Most>
Denial denial_in(const std::vector<SilhouetteAgreement>& checked, double SilhouetteAgreement::*share,
                 const Most& most) {
  std::map<int, Vote> votes;
  for (const SilhouetteAgreement& a : checked) ++votes[a.frame].cameras;
  for (const SilhouetteAgreement& a : checked) {
    Vote& vote = votes[a.frame];
    if (a.*share > most(vote.cameras)) vote.denied[a.serial] = a.*share;
  }
  Denial found;
  for (auto& [frame, vote] : votes) {
    if (!vote.contradicts()) continue;
    ++found.frames;
    if (vote.denied.size() <= found.vote.denied.size()) continue;
    found.worst = frame;
    found.vote = std::move(vote);
  }
  return found;
}

// What a key may have mistaken; nothing where nothing was keyed.
Result<std::string> colour_hint(const capture::TakeReader& take) {
  const Result<MatteRecord> record = load_matte_record(take.layout());
  if (!record) return forward(record);
  std::string hint;
  for (const auto& [serial, camera] : *record) {
    const std::string word = method_name(camera.key);
    if (!is_keyer(word)) continue;
    if (word == "chroma") return std::string(" (does the performer wear the cloth's colour?)");
    hint = " (does the performer wear the backdrop's colours?)";
  }
  return hint;
}

}  // namespace

Result<std::optional<MatteDoubt>> contradiction_in(capture::TakeReader& take,
                                                   const std::vector<SilhouetteAgreement>& checked,
                                                   bool draw) {
  const auto always = [](double most) { return [most](int) { return most; }; };
  Denial found = denial_in(checked, &SilhouetteAgreement::surplus, always(kMost));
  std::string why =
      "the hull of the other cameras denies more than half of the subject, and so in half of the cameras: "
      "these mattes are wrong, or those of cameras that miss the subject";
  if (found.frames == 0) {
    const char* how = ", and more than a twentieth in half of the cameras";
    found = denial_in(checked, &SilhouetteAgreement::denied, always(kDenied));
    if (found.frames == 0) {
      how = " in whole pieces, in half of the cameras";
      found = denial_in(checked, &SilhouetteAgreement::pieces, most_in_pieces);
    }
    if (found.frames == 0) return std::optional<MatteDoubt>();
    const Result<std::string> hint = colour_hint(take);
    if (!hint) return forward(hint);
    why =
        text("the hull of all cameras denies ", std::lround(100 * found.vote.typical()), " % of the subject",
             how, ": mattes lack what others show", *hint, ", or the calibration is off");
  }
  MatteDoubt doubt{.why = why + "; choose another --matte with --redo",
                   .cameras = {},
                   .frames = found.frames,
                   .worst = found.worst,
                   .picture = doubts_folder(take.layout()) / text("denied-", found.worst, ".png")};
  std::vector<int> cameras;
  for (const auto& [serial, share] : found.vote.denied) doubt.cameras.push_back(serial);
  for (std::size_t i = 0; i < take.rig().cameras.size(); ++i)
    if (found.vote.denied.contains(take.rig().cameras[i].serial)) cameras.push_back(static_cast<int>(i));
  if (draw || !is_there(doubt.picture)) {
    const Result<Image> sheet = doubt_sheet(take, cameras, doubt.worst);
    if (!sheet) return forward(sheet);
    const DoubtPicture what{.of = "hull", .why = doubt.why, .cameras = doubt.cameras, .frame = doubt.worst};
    if (Result<void> ok =
            DoubtPictures(doubts_folder(take.layout())).put(doubt.picture.filename(), what, *sheet);
        !ok)
      return forward(ok);
  }
  if (!is_there(doubt.picture)) doubt.picture.clear();
  return std::optional(std::move(doubt));
}

Result<void> keep_denials(const TakeLayout& layout, const std::optional<MatteDoubt>& said,
                          const std::set<int>& frames) {
  return DoubtPictures(doubts_folder(layout))
      .keep("hull", [&](const std::string& name, const DoubtPicture& picture) {
        return (said && said->picture.filename() == name) || !frames.contains(picture.frame);
      });
}

void add_contradiction(MatteDoubt contradiction, std::vector<MatteDoubt>& doubts) {
  std::erase_if(doubts, [&](const MatteDoubt& d) {
    return d.why.find(kDeniedByOthers) != std::string::npos &&
           std::all_of(d.cameras.begin(), d.cameras.end(), [&](const std::string& serial) {
             return std::count(contradiction.cameras.begin(), contradiction.cameras.end(), serial) > 0;
           });
  });
  doubts.insert(doubts.begin(), std::move(contradiction));
}

}  // namespace floatstage::pipeline
