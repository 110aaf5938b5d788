#include "pipeline/keying.h"

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/png.h"
#include "core/text.h"

namespace floatstage::pipeline {

using nlohmann::json;

Result<std::optional<KeyingRecord>> load_keying(const TakeLayout& layout, const Rig& rig) {
  Result<std::string> bytes = read_file(layout.keying());
  if (!bytes && bytes.error().code == ErrorCode::NotFound) return std::optional<KeyingRecord>();
  if (!bytes) return forward(bytes);
  const json j = json::parse(*bytes, nullptr, false);
  auto bad = [&] {
    return fail(ErrorCode::BadData,
                text(layout.keying().string(), " does not say how the mattes were made; remove the folder ",
                     layout.mattes().string(), " and run `floatstage process` again"));
  };
  if (!j.is_object() || !j.contains("key") || !j["key"].is_string()) return bad();
  KeyingRecord record{j["key"].get<std::string>(), {}};
  if (j.contains("cameras")) {
    if (!j["cameras"].is_object()) return bad();
    for (const RigCamera& c : rig.cameras) {
      if (!j["cameras"].contains(c.serial) || !j["cameras"][c.serial].is_string()) return bad();
      record.specs.push_back(j["cameras"][c.serial].get<std::string>());
    }
  }
  return std::optional<KeyingRecord>(std::move(record));
}

Result<void> save_keying(const KeyingRecord& record, const TakeLayout& layout, const Rig& rig) {
  json j = {{"key", record.key}};
  for (std::size_t i = 0; i < record.specs.size(); ++i) j["cameras"][rig.cameras[i].serial] = record.specs[i];
  return write_file(layout.keying(), j.dump(2) + "\n");
}

Result<std::unique_ptr<matting::Keyer>> keyer_for(capture::TakeReader& take, int camera,
                                                  const std::string& spec) {
  const std::string& serial = take.rig().cameras[static_cast<std::size_t>(camera)].serial;
  std::vector<Image> samples;
  const std::filesystem::path plate = take.layout().plate(serial);
  if (std::filesystem::exists(plate)) {
    Result<Image> picture = load_png(plate);
    if (!picture) return forward(picture);
    samples.push_back(std::move(*picture));
  } else {
    constexpr int kPhotographs =
        3;  // spread over the take: the cloth's colour does not change, the performer moves
    const int count = take.frame_count(), wanted = std::min(kPhotographs, count);
    for (int i = 0; i < wanted; ++i) {
      Result<Frame> frame = take.frame(camera, static_cast<int>(static_cast<long>(count) * i / wanted));
      if (!frame) return forward(frame);
      if (frame->empty()) continue;
      Result<Image> picture = to_rgb(*frame);
      if (!picture) return forward(picture);
      samples.push_back(std::move(*picture));
    }
  }
  Result<std::unique_ptr<matting::Keyer>> keyer = matting::make_keyer(spec, samples);
  if (!keyer) return fail(keyer.error().code, text("camera '", serial, "': ", keyer.error().message));
  return keyer;
}

}  // namespace floatstage::pipeline
