#include "calib/rig_formats.h"

#include <algorithm>
#include <array>

#include "calib/formats/format_files.h"
#include "core/rig_io.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

namespace fs = std::filesystem;

bool is_file(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

// What the names of a format's one file look like.
struct FileName {
  const char* pattern;  // for people
  bool (*fits)(std::string_view name);
};

constexpr FileName kRigJson{"rig.json", [](std::string_view n) { return n == "rig.json"; }};
constexpr FileName kTransforms{"transforms*.json", [](std::string_view n) {
                                 return n.starts_with("transforms") && n.ends_with(".json");
                               }};
constexpr FileName kSfmData{
    "sfm_data*.json", [](std::string_view n) { return n.starts_with("sfm_data") && n.ends_with(".json"); }};
constexpr FileName kPanoptic{"calibration_*.json", [](std::string_view n) {
                               return n.starts_with("calibration_") && n.ends_with(".json");
                             }};
constexpr FileName kParTxt{"*_par.txt", [](std::string_view n) { return n.ends_with("_par.txt"); }};
constexpr FileName kQcaTxt{"*.qca.txt", [](std::string_view n) { return n.ends_with(".qca.txt"); }};
constexpr FileName kCamchain{"*camchain*.yaml", [](std::string_view n) {
                               return n.find("camchain") != n.npos && n.ends_with(".yaml");
                             }};
constexpr FileName kDomeTxt{"*calibration.txt",
                            [](std::string_view n) { return n.ends_with("calibration.txt"); }};

// The files in a folder that fit, sorted.
std::vector<fs::path> fitting(const fs::path& folder, const FileName& name, std::error_code& error) {
  std::vector<fs::path> found;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (name.fits(it->path().filename().string())) found.push_back(it->path());
  std::sort(found.begin(), found.end());
  return found;
}

// `path` itself when it is a file, else the one file in it that fits.
Result<fs::path> find_file(const fs::path& path, const FileName& name) {
  std::error_code error;
  if (is_file(path)) return path;
  if (!fs::is_directory(path, error))
    return fail(ErrorCode::NotFound, text(path.string(), ": there is no such file or folder"));
  const std::vector<fs::path> found = fitting(path, name, error);
  if (error) return fail(ErrorCode::Io, text(path.string(), ": cannot list this folder: ", error.message()));
  if (found.empty())
    return fail(ErrorCode::NotFound,
                text(path.string(), ": there is no file ", name.pattern, " in this folder"));
  if (found.size() > 1)
    return fail(ErrorCode::InvalidArgument,
                text(path.string(), ": holds ", found.size(), " files ", name.pattern, " (",
                     found[0].filename().string(), ", ", found[1].filename().string(),
                     ", …); name the one you mean"));
  return found[0];
}

template <const FileName& kName>
bool has_file(const fs::path& path) {
  std::error_code ignored;
  return is_file(path) ? kName.fits(path.filename().string()) : !fitting(path, kName, ignored).empty();
}

// COLMAP keeps models in <project>/sparse/0 or wherever the user wrote them.
fs::path colmap_model(const fs::path& folder) {
  for (const fs::path& below : {folder, folder / "sparse" / "0", folder / "sparse"})
    if (is_file(below / "images.bin") || is_file(below / "images.txt")) return below;
  return folder;
}

bool is_colmap(const fs::path& folder) {
  const fs::path model = colmap_model(folder);
  return is_file(model / "images.bin") || is_file(model / "images.txt");
}

// Any JSON file whose name is not another format's.
bool is_own(const fs::path& path) {
  const std::string name = path.filename().string();
  const bool others = kTransforms.fits(name) || kSfmData.fits(name) || kPanoptic.fits(name);
  return has_file<kRigJson>(path) || (path.extension() == ".json" && !others);
}

Result<ForeignRig> with_pictures(Result<ForeignRig> foreign, fs::path pictures) {
  if (foreign) foreign->pictures = std::move(pictures);
  return foreign;
}

Result<ForeignRig> read_own(const fs::path& file) {
  Result<Rig> rig = load_rig(file);
  if (!rig) return forward(rig);
  ForeignRig foreign;
  for (const RigCamera& c : rig->cameras) foreign.image_names.push_back(c.serial);
  foreign.rig = *std::move(rig);
  return foreign;
}

// Formats of one file, whose pictures lie in its folder or in a folder beside it.
template <const FileName& kName, auto kRead>
Result<ForeignRig> read_file_of(const fs::path& path, double) {
  const Result<fs::path> file = find_file(path, kName);
  if (!file) return forward(file);
  return with_pictures(kRead(*file), file->parent_path());
}

Result<ForeignRig> read_dome_of(const fs::path& path, double metres_per_unit) {
  const Result<fs::path> file = find_file(path, kDomeTxt);
  if (!file) return forward(file);
  return with_pictures(read_dome(*file, metres_per_unit), file->parent_path() / "images");
}

Result<ForeignRig> read_colmap_of(const fs::path& path, double) {
  return with_pictures(read_colmap(colmap_model(path)), path / "images");
}

Result<ForeignRig> read_easymocap_of(const fs::path& path, double) {
  return with_pictures(read_easymocap(path), path / "images");
}

// Those that carry no names of pictures.
template <auto kWrite>
Result<void> nameless(const Rig& rig, const std::vector<std::string>&, const fs::path& out) {
  return kWrite(rig, out);
}

constexpr std::array kFormats = {
    RigFormat{.name = "rig",
              .title = "Floatstage's own rig.json",
              .files = "a rig.json, or a folder that holds one",
              .written = "",
              .recognises = is_own,
              .read = read_file_of<kRigJson, read_own>,
              .write = nullptr},
    RigFormat{.name = "middlebury",
              .title = "Middlebury multi-view stereo",
              .files = "a folder with one *_par.txt and the images, or that file",
              .written = "a _par.txt",
              .holds = {.radial = 0, .tangential = false, .fisheye = false},
              .recognises = has_file<kParTxt>,
              .read = read_file_of<kParTxt, read_middlebury>,
              .write = write_middlebury},
    RigFormat{.name = "colmap",
              .title = "COLMAP model, binary or text",
              .files = "a folder with cameras and images as .bin or .txt, or a project's",
              .written = "a folder with cameras, images, points3D as .bin and .txt",
              .holds = {.radial = 6, .skew = false},
              .recognises = is_colmap,
              .read = read_colmap_of,
              .write = write_colmap},
    RigFormat{.name = "opencv",
              .title = "OpenCV / EasyMocap YAML",
              .files = "a folder with intri.yml and extri.yml",
              .written = "a folder with intri.yml and extri.yml, as EasyMocap has them",
              .holds = {.radial = 6, .skew = false, .fisheye = false},
              .recognises = [](const fs::path& p) { return is_file(p / "intri.yml"); },
              .read = read_easymocap_of,
              .write = nameless<write_easymocap>},
    RigFormat{.name = "kalibr",
              .title = "Kalibr camchain",
              .files = "a camchain .yaml, or a folder with one *camchain*.yaml",
              .written = "a camchain .yaml",
              .holds = {.radial = 2, .skew = false},
              .recognises = has_file<kCamchain>,
              .read = read_file_of<kCamchain, read_kalibr>,
              .write = nameless<write_kalibr>},
    RigFormat{.name = "qualisys",
              .title = "Qualisys calibration",
              .files = "a .qca.txt, or a folder with one",
              .written = "a .qca.txt",
              .holds = {.fisheye = false},
              .recognises = has_file<kQcaTxt>,
              .read = read_file_of<kQcaTxt, read_qualisys>,
              .write = nameless<write_qualisys>},
    RigFormat{.name = "transforms",
              .title = "transforms.json of nerfstudio, instant-ngp and NeRF",
              .files = "a transforms*.json, or a folder with one",
              .written = "",
              .recognises = has_file<kTransforms>,
              .read = read_file_of<kTransforms, read_transforms>,
              .write = nullptr},
    RigFormat{.name = "openmvg",
              .title = "OpenMVG scene",
              .files = "an sfm_data*.json, or a folder with one",
              .written = "",
              .recognises = has_file<kSfmData>,
              .read = read_file_of<kSfmData, read_openmvg>,
              .write = nullptr},
    RigFormat{.name = "mve",
              .title = "MVE scene (Multi-View Environment)",
              .files = "a folder with views/*.mve/, or that views/",
              .written = "",
              .recognises = is_mve,
              .read = [](const fs::path& p, double) { return read_mve(p); },
              .write = nullptr},
    RigFormat{.name = "panoptic",
              .title = "CMU Panoptic Studio calibration",
              .files = "a calibration_*.json, or a folder with one",
              .written = "",
              .recognises = has_file<kPanoptic>,
              .read = read_file_of<kPanoptic, read_panoptic>,
              .write = nullptr},
    RigFormat{.name = "dome",
              .title = "Plain text of the green dome",
              .files = "a folder with calibration.txt and images/, or that file",
              .written = "",
              .states_unit = false,
              .recognises = has_file<kDomeTxt>,
              .read = read_dome_of,
              .write = nullptr},
    RigFormat{.name = "lightfield",
              .title = "A light field's pictures, named after where they were taken",
              .files = "a folder of NAME_<row>_<column>_<y mm>_<x mm>_<focal mm>_<sensor mm>.jpg",
              .written = "",
              .recognises = names_a_lightfield,
              .read = [](const fs::path& p, double) { return read_lightfield(p); },
              .write = nullptr},
};

Result<const RigFormat*> recognised(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error))
    return fail(ErrorCode::NotFound, text(path.string(), ": there is no such file or folder"));
  const RigFormat* found = nullptr;
  std::string names;
  for (const RigFormat& f : kFormats) {
    if (!f.recognises(path)) continue;
    names += text(found ? " or " : "", f.name);
    found = &f;
  }
  if (!found)
    return fail(ErrorCode::NotFound,
                text(path.string(), ": is no calibration by its name, and holds none; name its format (",
                     rig_format_names(), ")"));
  if (names != found->name)
    return fail(ErrorCode::InvalidArgument, text(path.string(), ": could be ", names, "; name the format"));
  return found;
}

}  // namespace

std::span<const RigFormat> rig_formats() { return kFormats; }

std::string rig_format_names() {
  std::string names(kAnyRigFormat);
  for (const RigFormat& f : kFormats) names += text(", ", f.name);
  return names;
}

Result<const RigFormat*> rig_format(std::string_view name, const fs::path& path) {
  if (name == kAnyRigFormat) return recognised(path);
  const auto* const found =
      std::find_if(kFormats.begin(), kFormats.end(), [&](const RigFormat& f) { return f.name == name; });
  if (found == kFormats.end())
    return fail(ErrorCode::InvalidArgument,
                text("'", name, "' is no calibration format; there are ", rig_format_names()));
  return found;
}

Result<ForeignRig> read_rig(const RigFile& file) {
  const Result<const RigFormat*> format = rig_format(file.format, file.path);
  if (!format) return forward(format);
  return (*format)->read(file.path, file.metres_per_unit);
}

}  // namespace floatstage::calib
