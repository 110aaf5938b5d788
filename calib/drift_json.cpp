#include <cmath>

#include <nlohmann/json.hpp>

#include "calib/drift.h"
#include "core/file.h"
#include "core/json_fields.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

constexpr const char* kDigits = "0123456789abcdef";
constexpr std::size_t kBytes = static_cast<std::size_t>(kDriftPatch) * kDriftPatch;

std::string hexadecimal(const std::vector<std::uint8_t>& bytes) {
  std::string digits;
  for (const std::uint8_t b : bytes) digits += {kDigits[b >> 4], kDigits[b & 15]};
  return digits;
}

std::vector<std::uint8_t> bytes_of(const std::string& digits, const std::string& where,
                                   JsonProblem& problem) {
  const std::string_view known = kDigits;
  std::vector<std::uint8_t> bytes;
  bool good = digits.size() == 2 * kBytes;
  for (std::size_t i = 0; good && i < digits.size(); i += 2) {
    const std::size_t high = known.find(digits[i]), low = known.find(digits[i + 1]);
    good = high != known.npos && low != known.npos;
    bytes.push_back(static_cast<std::uint8_t>(16 * high + low));
  }
  if (!good) problem.note(where, text("'grey' is not ", 2 * kBytes, " hexadecimal digits"));
  return bytes;
}

}  // namespace

std::string to_json(const DriftReference& reference) {
  nlohmann::ordered_json cameras = nlohmann::ordered_json::array();
  for (std::size_t c = 0; c < reference.serials.size(); ++c) {
    nlohmann::ordered_json patches = nlohmann::ordered_json::array();
    for (const DriftPatch& p : reference.patches[c])
      patches.push_back({{"at", {p.at.x(), p.at.y()}}, {"grey", hexadecimal(p.grey)}});
    cameras.push_back({{"serial", reference.serials[c]}, {"patches", std::move(patches)}});
  }
  return print_json({{"floatstage_drift_reference", 1}, {"cameras", std::move(cameras)}});
}

Result<DriftReference> parse_drift_reference(std::string_view bytes, std::string_view name) {
  const Result<nlohmann::json> document = parse_json(bytes, name);
  if (!document) return forward(document);
  JsonProblem problem;
  JsonFields fields(*document, std::string(name), problem);
  if (const int version = fields.integer("floatstage_drift_reference"); !problem.first && version != 1)
    return fail(ErrorCode::Unsupported,
                text(name, ": drift reference ", version, " is not known here; make it anew"));
  DriftReference reference;
  if (const nlohmann::json* cameras = fields.list("cameras")) {
    for (const nlohmann::json& value : *cameras) {
      JsonFields camera(value, text(name, ": camera ", reference.serials.size()), problem);
      reference.serials.push_back(camera.string("serial"));
      auto& patches = reference.patches.emplace_back();
      if (const nlohmann::json* list = camera.list("patches")) {
        for (const nlohmann::json& each : *list) {
          JsonFields patch(each, text(camera.where(), ": patch ", patches.size()), problem);
          const std::vector<double> at = patch.numbers("at", 2);
          if (!(std::abs(at[0]) < 1e6 && std::abs(at[1]) < 1e6))
            problem.note(patch.where(), "'at' is not a place in a picture");
          patches.push_back({{at[0], at[1]}, bytes_of(patch.string("grey"), patch.where(), problem)});
          patch.refuse_others();
        }
      }
      camera.refuse_others();
    }
  }
  fields.refuse_others();
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  return reference;
}

Result<DriftReference> load_drift_reference(const std::filesystem::path& file) {
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  return parse_drift_reference(*bytes, file.string());
}

Result<void> save_drift_reference(const DriftReference& reference, const std::filesystem::path& file) {
  return write_file(file, to_json(reference));
}

}  // namespace floatstage::calib
