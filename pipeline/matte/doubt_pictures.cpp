#include "pipeline/matte/doubt_pictures.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/json_fields.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/derived_files.h"
#include "pipeline/made_files.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kVersion = 1;
constexpr const char* kRecord = "made.json";

// A name that leads elsewhere is none of ours.
bool is_picture(const std::string& name) {
  const fs::path path = name;
  return path.filename() == path && path.extension() == ".png";
}

std::map<std::string, DoubtPicture> read(const fs::path& file) {
  std::map<std::string, DoubtPicture> pictures;
  const Result<std::string> bytes = read_file(file);
  const Result<json> j = bytes ? parse_json(*bytes, file.string()) : Result<json>(forward(bytes));
  if (!j) return pictures;
  try {
    if (j->at("floatstage_doubts") != kVersion) return pictures;
    for (const auto& [name, p] : j->at("pictures").items())
      if (is_picture(name))
        pictures[name] = {p.at("of"), p.at("why"), p.at("cameras"), p.at("frame"), p.at("sha256")};
  } catch (const std::exception&) {  // JSON's
    pictures.clear();
  }
  return pictures;
}

}  // namespace

DoubtPictures::DoubtPictures(fs::path folder)
    : folder_(std::move(folder)), pictures_(read(folder_ / kRecord)) {}

Result<void> DoubtPictures::put(const std::string& name, DoubtPicture what, const Image& picture) {
  if (picture.pixels.empty()) return {};
  if (Result<void> ok = make_folder(folder_); !ok) return ok;
  if (Result<void> ok = save_png(picture, folder_ / name); !ok) return ok;
  return know(name, std::move(what));
}

Result<void> DoubtPictures::take_in(const fs::path& file, const std::string& name, DoubtPicture what) {
  if (Result<void> ok = move_file(file, folder_ / name); !ok) return ok;
  return know(name, std::move(what));
}

Result<void> DoubtPictures::know(const std::string& name, DoubtPicture what) {
  const Result<std::optional<std::string>> hash = hash_of(folder_ / name);
  if (!hash) return forward(hash);
  what.sha256 = hash->value_or("");
  pictures_[name] = std::move(what);
  return save();
}

std::optional<int> DoubtPictures::frame_of(const std::string& why,
                                           const std::vector<std::string>& cameras) const {
  std::error_code none;
  for (const auto& [name, picture] : pictures_)
    if (picture.why == why && picture.cameras == cameras && fs::exists(folder_ / name, none))
      return picture.frame;
  return std::nullopt;
}

Result<void> DoubtPictures::keep(
    const std::string& of, const std::function<bool(const std::string& name, const DoubtPicture&)>& holds) {
  std::error_code error;
  if (fs::is_symlink(folder_, error)) return {};
  bool any = false;
  for (auto it = pictures_.begin(); it != pictures_.end();) {
    const auto& [name, picture] = *it;
    if (picture.of != of || holds(name, picture)) {
      ++it;
      continue;
    }
    const fs::path file = folder_ / name;
    if (fs::symlink_status(file, error).type() == fs::file_type::regular) {
      const Result<std::optional<std::string>> hash = hash_of(file);
      if (!hash) return forward(hash);
      if (*hash == picture.sha256 && !fs::remove(file, error) && error)
        return fail(ErrorCode::Io, text("cannot remove ", file.string(), ": ", error.message()));
    }
    it = pictures_.erase(it);
    any = true;
  }
  return any ? save() : Result<void>();
}

Result<void> DoubtPictures::save() const {
  std::error_code error;
  if (pictures_.empty()) {
    fs::remove(folder_ / kRecord, error);
    if (fs::is_empty(folder_, error)) fs::remove(folder_, error);
    return {};
  }
  json pictures = json::object();
  for (const auto& [name, p] : pictures_)
    pictures[name] = {
        {"of", p.of}, {"why", p.why}, {"cameras", p.cameras}, {"frame", p.frame}, {"sha256", p.sha256}};
  const json whole = {{"floatstage_doubts", kVersion}, {"pictures", std::move(pictures)}};
  return write_file(folder_ / kRecord, whole.dump(1) + "\n");
}

}  // namespace floatstage::pipeline
