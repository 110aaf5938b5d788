// A whole take, opened as the verbs do. The input is the folder in one file (pack_take.py writes it): before
// each of its files a line "@@F <name>", "@@D <name>" for a folder, "@@L <name> <to>" for a link in a file's
// place. Marks, not lengths: what is damaged in one file leaves the others whole.

#include <cstdint>
#include <optional>

#include "capture/derivation.h"
#include "capture/take.h"
#include "capture/take_check.h"
#include "capture/time_offsets.h"
#include "core/check.h"
#include "core/log.h"
#include "core/matte_edits.h"
#include "core/mesh_io.h"
#include "pipeline/camera_path.h"
#include "pipeline/derive/list_takes.h"
#include "pipeline/matte_record.h"
#include "pipeline/mesh_record.h"
#include "pipeline/scene_loader.h"
#include "tests/fuzz/scratch_folder.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostFiles = 64;

// Stays in the folder.
bool is_harmless(const std::string& name) {
  return !name.empty() && name.size() < 100 && name[0] != '/' && name.find("..") == std::string::npos &&
         name.find('\0') == std::string::npos;
}

void put(char kind, std::string name, std::string_view bytes, const fs::path& folder) {
  std::error_code ignored;
  std::string to;
  if (const std::size_t space = name.find(' '); kind == 'L' && space != std::string::npos) {
    to = name.substr(space + 1);
    name.resize(space);
  }
  if (!is_harmless(name)) return;
  const fs::path file = folder / name;
  fs::create_directories(file.parent_path(), ignored);
  if (kind == 'D') fs::create_directory(file, ignored);
  if (kind == 'L' && (to == "/dev/zero" || (is_harmless(to) && to.find('/') == std::string::npos)))
    fs::create_symlink(to, file, ignored);
  if (kind == 'F' && !fs::is_symlink(file, ignored))
    std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

void unpack(std::string_view rest, const fs::path& folder) {
  constexpr std::string_view kMark = "\n@@";
  std::error_code ignored;
  fs::create_directories(folder, ignored);
  std::size_t at = rest.find(kMark);
  for (std::size_t files = 0; files < kMostFiles && at != std::string_view::npos; ++files) {
    rest.remove_prefix(at + kMark.size());
    at = rest.find(kMark);
    const std::string_view entry = rest.substr(0, at);
    const std::size_t line = std::min(entry.find('\n'), entry.size());
    if (line < 2) continue;
    put(entry[0], std::string(entry.substr(2, line - 2)), entry.substr(std::min(line + 1, entry.size())),
        folder);
  }
}

// Every picture that the take says it has is one of its cameras', or none.
void claim_frames(capture::TakeReader& take) {
  const std::size_t cameras = take.rig().cameras.size();
  FLOATSTAGE_CHECK(take.manifest().cameras.size() == cameras, "cameras without calibration");
  const int frames = std::min(take.frame_count(), 4);
  for (std::size_t c = 0; c < cameras; ++c)
    for (int f = 0; f < frames; ++f) {
      const Result<Frame> frame = take.frame(static_cast<int>(c), f);
      if (!frame || frame->empty()) continue;
      const TakeManifest::Camera& said = take.manifest().cameras[c];
      FLOATSTAGE_CHECK(frame->layout.width == said.width && frame->layout.height == said.height,
                       "a picture of another size");
      static_cast<void>(to_rgb(*frame));
    }
}

void claim_mattes_and_meshes(capture::TakeReader& take) {
  const TakeLayout& layout = take.layout();
  static_cast<void>(pipeline::load_matte_record(layout));
  static_cast<void>(load_matte_edits(layout.edits()));
  if (const auto mattes = pipeline::load_mattes(take, 0))
    for (std::size_t c = 0; c < mattes->size(); ++c)
      FLOATSTAGE_CHECK((*mattes)[c].empty() || (*mattes)[c].width == take.rig().cameras[c].model.width,
                       "a matte of another size");
  static_cast<void>(pipeline::load_mesh_record(layout));
  if (const Result<Mesh> mesh = load_ply(layout.mesh(0)))
    for (const std::uint32_t i : mesh->triangles)
      FLOATSTAGE_CHECK(i < mesh->positions.size(), "an index out of range");
  static_cast<void>(pipeline::SceneLoader(take, true).load(0));
}

}  // namespace
}  // namespace floatstage

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace floatstage;
  log::set_level(log::Level::Off);
  const fs::path folder = fuzz_folder() / "take";
  unpack({reinterpret_cast<const char*>(data), size}, folder);
  const auto check = capture::check_take(folder, [](std::uint64_t) { return true; });
  FLOATSTAGE_CHECK(!check || check->pictures >= 0, "fewer pictures than none");
  if (const auto takes = pipeline::list_takes(folder))
    for (const pipeline::ListedTake& listed : *takes)
      FLOATSTAGE_CHECK(!listed.verdict.empty(), "a take of which there is nothing to say");
  if (const auto take = capture::TakeReader::open(folder)) {
    claim_frames(**take);
    claim_mattes_and_meshes(**take);
    static_cast<void>(capture::load_derivation(folder));
    static_cast<void>(capture::load_time_offsets((*take)->layout()));
    static_cast<void>(pipeline::rig_with_colors(**take));
    static_cast<void>(pipeline::load_path(folder / "path.json"));
  }
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  return 0;
}
