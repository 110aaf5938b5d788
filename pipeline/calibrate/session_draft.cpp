#include "pipeline/calibrate/session_draft.h"

#include <cmath>

#include "core/rig.h"
#include "core/text.h"

namespace floatstage::pipeline {

namespace fs = std::filesystem;

std::string SessionDraft::quoted(const std::string& s) {
  std::string q = "\"";
  for (const char c : s) q += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return q + "\"";
}

std::string SessionDraft::path(const fs::path& p) const {
  std::error_code error;
  const fs::path from = fs::weakly_canonical(written_to, error), to = fs::weakly_canonical(p, error);
  const fs::path relative = to.lexically_relative(from);
  return quoted((relative.empty() ? to : relative).string());
}

std::string SessionDraft::paths(const std::vector<fs::path>& list) const {
  if (list.size() == 1) return path(list.front());
  std::string all;
  for (const fs::path& p : list) all += (all.empty() ? "" : ", ") + path(p);
  return "[" + all + "]";
}

void SessionDraft::camera(const std::string& serial, const std::string& key, const std::string& value) {
  cameras += text("\n[[cameras]]\nserial = ", quoted(serial), "\n", key, " = ", value, "\n");
  ++out.cameras;
}

void SessionDraft::known(const char* intrinsics, const char* poses) {
  const calib::RigFile& file = *survey.calibration;
  tables += text("\n[known]\nfile = ", path(file.path), "\nformat = ", quoted(file.format),
                 "\nintrinsics = \"", intrinsics, "\"\nposes = \"", poses, "\"\n");
  const Result<const calib::RigFormat*> format = calib::rig_format(file.format, file.path);
  if (!format || (*format)->states_unit) return;
  tables += text("metres_per_unit = ", file.metres_per_unit, "\n");
  assume(text("a unit of ", file.path.string(), " is ", file.metres_per_unit,
              " m: the format states none (metres_per_unit in [known])"));
}

std::string usable_serial(std::string name) {
  for (char& c : name)
    if (!is_usable_serial(std::string("a") + c)) c = '_';
  return is_usable_serial(name) ? name : "cam_" + name;
}

}  // namespace floatstage::pipeline
