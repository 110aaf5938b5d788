#include "pipeline/import/calibration_input.h"

#include <algorithm>
#include <vector>

#include "core/text.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

// `path` itself when it is a file, else the one file below it whose name ends in `ending`.
Result<fs::path> find_file(const fs::path& path, std::string_view ending) {
  std::error_code error;
  if (fs::is_regular_file(path, error)) return path;
  if (!fs::is_directory(path, error))
    return fail(ErrorCode::NotFound, text(path.string(), ": there is no such file or folder"));
  std::vector<fs::path> found;
  for (fs::directory_iterator it(path, error), end; !error && it != end; it.increment(error))
    if (it->path().filename().string().ends_with(ending)) found.push_back(it->path());
  if (error) return fail(ErrorCode::Io, text(path.string(), ": cannot list this folder: ", error.message()));
  if (found.empty())
    return fail(ErrorCode::NotFound, text(path.string(), ": there is no file *", ending, " in this folder"));
  std::sort(found.begin(), found.end());
  if (found.size() > 1)
    return fail(
        ErrorCode::InvalidArgument,
        text(path.string(), ": holds ", found.size(), " files *", ending, " (", found[0].filename().string(),
             ", ", found[1].filename().string(), ", …); name the one you mean"));
  return found[0];
}

// COLMAP keeps text models in <project>/sparse/0 or wherever the user wrote them.
fs::path colmap_model(const fs::path& folder) {
  for (const fs::path& below : {folder, folder / "sparse" / "0", folder / "sparse"}) {
    std::error_code error;
    if (fs::exists(below / "images.txt", error)) return below;
  }
  return folder;
}

Result<LoadedCalibration> with_pictures(Result<calib::ForeignRig> foreign, fs::path pictures) {
  if (!foreign) return forward(foreign);
  return LoadedCalibration{std::move(*foreign), std::move(pictures)};
}

}  // namespace

const char* name_of(CalibrationFormat format) {
  switch (format) {
    case CalibrationFormat::Middlebury:
      return "middlebury";
    case CalibrationFormat::Colmap:
      return "colmap";
    case CalibrationFormat::OpenCv:
      return "opencv";
    case CalibrationFormat::Qualisys:
      return "qualisys";
    case CalibrationFormat::Dome:
      return "dome";
  }
  return "unknown";
}

Result<LoadedCalibration> load_calibration(const CalibrationInput& input) {
  switch (input.format) {
    case CalibrationFormat::Middlebury: {
      const Result<fs::path> file = find_file(input.path, "_par.txt");
      if (!file) return forward(file);
      return with_pictures(calib::read_middlebury(*file), file->parent_path());
    }
    case CalibrationFormat::Colmap:
      return with_pictures(calib::read_colmap(colmap_model(input.path)), input.path / "images");
    case CalibrationFormat::OpenCv:
      return with_pictures(calib::read_easymocap(input.path), input.path / "images");
    case CalibrationFormat::Qualisys: {
      const Result<fs::path> file = find_file(input.path, ".qca.txt");
      if (!file) return forward(file);
      return with_pictures(calib::read_qualisys(*file), file->parent_path());
    }
    case CalibrationFormat::Dome: {
      const Result<fs::path> file = find_file(input.path, "calibration.txt");
      if (!file) return forward(file);
      return with_pictures(calib::read_dome(*file, input.metres_per_unit), file->parent_path() / "images");
    }
  }
  return fail(ErrorCode::InvalidArgument, "unknown calibration format");
}

}  // namespace floatstage::pipeline
