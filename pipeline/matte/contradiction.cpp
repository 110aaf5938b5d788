#include "pipeline/matte/contradiction.h"

#include <algorithm>
#include <string>

#include "core/file_presence.h"
#include "core/text.h"
#include "pipeline/matte/consistent_verdict.h"
#include "pipeline/matte/doubt_pictures.h"
#include "pipeline/matte/doubt_sheet.h"
#include "pipeline/matte/matte_how.h"
#include "pipeline/matte_record.h"
#include "recon/silhouette_contradiction.h"

namespace floatstage::pipeline {
namespace {

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
                                                   const std::vector<recon::SilhouetteAgreement>& checked,
                                                   bool draw) {
  const std::optional<recon::SilhouetteContradiction> found = recon::contradiction_between(checked);
  if (!found) return std::optional<MatteDoubt>();
  const Result<std::string> hint = colour_hint(take);
  if (!hint) return forward(hint);
  MatteDoubt doubt{.why = recon::describe(*found, *hint) + "; choose another --matte with --redo",
                   .cameras = {},
                   .frames = found->frames,
                   .worst = found->worst,
                   .picture = doubts_folder(take.layout()) / text("denied-", found->worst, ".png")};
  std::vector<int> cameras;
  for (const auto& [serial, share] : found->shares) doubt.cameras.push_back(serial);
  for (std::size_t i = 0; i < take.rig().cameras.size(); ++i)
    if (found->shares.contains(take.rig().cameras[i].serial)) cameras.push_back(static_cast<int>(i));
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
