#include "pipeline/matte/contradiction.h"

#include <map>
#include <set>

#include "core/file_presence.h"
#include "core/text.h"
#include "pipeline/matte/doubt_sheet.h"

namespace floatstage::pipeline {
namespace {

constexpr double kMost = 0.5;  // of a matte, and of the cameras: a majority

struct Vote {
  int cameras = 0;
  std::set<std::string> denied;
  bool contradicts() const {
    return static_cast<double>(denied.size()) >= kMost * cameras && denied.size() > 1;
  }
};

}  // namespace

Result<std::optional<MatteDoubt>> contradiction_in(capture::TakeReader& take,
                                                   const std::vector<SilhouetteAgreement>& checked) {
  std::map<int, Vote> votes;
  for (const SilhouetteAgreement& a : checked) {
    Vote& vote = votes[a.frame];
    ++vote.cameras;
    if (a.surplus > kMost) vote.denied.insert(a.serial);
  }
  MatteDoubt doubt{
      .why =
          "the hull of the other cameras denies more than half of the subject, and so in half of the "
          "cameras: "
          "these mattes are wrong, or those of cameras that miss the subject; choose another --matte with "
          "--redo, or let `process` weigh them one by one",
      .cameras = {},
      .frames = 0,
      .worst = 0,
      .picture = {}};
  for (const auto& [frame, vote] : votes) {
    if (!vote.contradicts()) continue;
    ++doubt.frames;
    if (vote.denied.size() <= doubt.cameras.size()) continue;
    doubt.worst = frame;
    doubt.cameras.assign(vote.denied.begin(), vote.denied.end());
  }
  if (doubt.frames == 0) return std::optional<MatteDoubt>();
  std::vector<int> cameras;
  for (std::size_t i = 0; i < take.rig().cameras.size(); ++i)
    if (votes[doubt.worst].denied.contains(take.rig().cameras[i].serial))
      cameras.push_back(static_cast<int>(i));
  doubt.picture = doubts_folder(take.layout()) / text("denied-", doubt.worst, ".png");
  if (Result<void> ok = save_doubt_sheet(take, cameras, doubt.worst, doubt.picture); !ok) return forward(ok);
  if (!is_there(doubt.picture)) doubt.picture.clear();
  return std::optional(std::move(doubt));
}

}  // namespace floatstage::pipeline
