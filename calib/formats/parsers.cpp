#include "calib/formats/parsers.h"

#include <set>

#include "core/text.h"

namespace floatstage::calib {

Result<ForeignRig> checked(ForeignRig foreign, std::string_view name) {
  if (foreign.rig.cameras.empty())
    return fail(ErrorCode::BadData, text(name, ": there is no camera in this file"));
  FLOATSTAGE_CHECK(foreign.image_names.size() == foreign.rig.cameras.size(), "one image name a camera");
  std::set<std::string> seen;
  for (const RigCamera& c : foreign.rig.cameras) {
    if (c.serial.empty()) return fail(ErrorCode::BadData, text(name, ": a camera's name is empty"));
    if (!seen.insert(c.serial).second)
      return fail(ErrorCode::BadData,
                  text(name, ": two cameras are named '", c.serial, "'; names must differ"));
  }
  return foreign;
}

Result<void> check_writable(const Rig& rig, const std::vector<std::string>& image_names,
                            std::string_view name) {
  if (Result<void> ok = check(rig); !ok) return fail(ok.error().code, text(name, ": ", ok.error().message));
  if (image_names.size() != rig.cameras.size())
    return fail(ErrorCode::InvalidArgument, text(name, ": ", image_names.size(), " image names for ",
                                                 rig.cameras.size(), " cameras; give one for each"));
  for (const std::string& image : image_names)
    if (image.empty() || image.find_first_of("\r\n") != std::string::npos)
      return fail(ErrorCode::InvalidArgument, text(name, ": an image name is empty or holds a line end"));
  return {};
}

}  // namespace floatstage::calib
