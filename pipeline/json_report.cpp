#include "pipeline/json_report.h"

#include <nlohmann/json.hpp>

#include "core/file.h"

namespace floatstage::pipeline {

Result<void> save_json(const nlohmann::json& report, const std::filesystem::path& file) {
  if (file.has_parent_path())
    if (Result<void> ok = make_folder(file.parent_path()); !ok) return ok;
  return write_file(file, report.dump(2) + "\n");
}

}  // namespace floatstage::pipeline
