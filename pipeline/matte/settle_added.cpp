#include "pipeline/matte/settle_added.h"

#include <utility>

#include "capture/added_file.h"
#include "core/file_presence.h"
#include "core/text.h"
#include "pipeline/take_added.h"

namespace floatstage::pipeline {
namespace {

std::vector<std::string> sentences(const capture::AddedFile& added) {
  std::vector<std::string> all;
  if (added.hidden) all = describe(added.cameras);
  for (std::string& s : all)
    s += " of the pictures were added by a camera or a converter, and are hidden (added.json; --added keep "
         "shows them)";
  return all;
}

Result<void> open_again(std::unique_ptr<capture::TakeReader>& take) {
  Result<std::unique_ptr<capture::TakeReader>> opened = capture::TakeReader::open(take->layout().folder());
  if (!opened) return forward(opened);
  take = std::move(*opened);
  return {};
}

}  // namespace

Result<std::vector<std::string>> settle_added(std::unique_ptr<capture::TakeReader>& take,
                                              std::optional<bool> hide, int threads) {
  const TakeLayout layout = take->layout();
  const bool known = is_there(capture::added_file(layout));
  Result<capture::AddedFile> before = capture::load_added(layout);
  if (!before) return forward(before);
  if (known && (!hide || *hide == before->hidden)) return sentences(*before);
  // Whatever is shown now is the recording itself: nothing is hidden yet, or it is not any more.
  const bool looks = hide.value_or(true);
  const capture::AddedFile now =
      looks ? search_added(*take, threads) : capture::AddedFile{.hidden = false, .cameras = {}};
  if (Result<void> ok = capture::save_added(now, layout); !ok) return forward(ok);
  if (!now.cameras.empty() || !before->cameras.empty())
    if (Result<void> ok = open_again(take); !ok) return forward(ok);
  return sentences(now);
}

}  // namespace floatstage::pipeline
