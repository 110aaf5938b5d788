#include "capture/derivation.h"

#include "core/file.h"
#include "core/file_presence.h"
#include "core/json_fields.h"

namespace floatstage::capture {
namespace {

std::filesystem::path file_in(const std::filesystem::path& take) { return take / "derived.json"; }

}  // namespace

Result<std::optional<Derivation>> load_derivation(const std::filesystem::path& take) {
  const std::filesystem::path file = file_in(take);
  if (!is_there(file)) return std::optional<Derivation>();
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  const Result<nlohmann::json> document = parse_json(*bytes, file.string());
  if (!document) return forward(document);
  JsonProblem problem;
  JsonFields fields(*document, file.string(), problem);
  Derivation d;
  const int version = fields.integer("floatstage_derivation");
  d.from = fields.string("from");
  d.how = fields.string("how");
  fields.refuse_others();
  if (!problem.first && version != 1) problem.note(file.string(), "a version that is not known here");
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  return std::optional(d);
}

Result<void> save_derivation(const Derivation& d, const std::filesystem::path& take) {
  return write_file(file_in(take),
                    print_json({{"floatstage_derivation", 1}, {"from", d.from}, {"how", d.how}}));
}

}  // namespace floatstage::capture
