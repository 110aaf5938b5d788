#include "calib/markerless.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "calib/child_program.h"
#include "calib/formats/text_lines.h"
#include "calib/rig_formats.h"
#include "core/file.h"
#include "core/parallel.h"
#include "core/text.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;

std::string number(double v) {
  std::ostringstream out;
  out.precision(17);
  out << v;
  return out.str();
}

// COLMAP's name and parameters for a camera; its pixel convention is ours.
std::pair<std::string, std::string> colmap_camera(const CameraModel& m) {
  std::string p = text(number(m.fx), ",", number(m.fy), ",", number(m.cx), ",", number(m.cy));
  auto add = [&](std::initializer_list<double> more) {
    for (const double v : more) p += "," + number(v);
  };
  if (const auto* b = std::get_if<BrownConrady>(&m.lens)) {
    add({b->k1, b->k2, b->p1, b->p2, b->k3, 0, 0, 0});
    return {"FULL_OPENCV", p};
  }
  if (const auto* k = std::get_if<KannalaBrandt>(&m.lens)) {
    add({k->k1, k->k2, k->k3, k->k4});
    return {"OPENCV_FISHEYE", p};
  }
  return {"PINHOLE", p};
}

class Colmap {
 public:
  Colmap(const MarkerlessOptions& options, fs::path workspace)
      : options_(options), log_(workspace / "colmap.log"), workspace_(std::move(workspace)) {}

  // One step; `advice` is what to do when COLMAP gives up.
  Result<void> run(const std::string& step, std::vector<std::string> arguments, const std::string& advice) const {
    std::vector<std::string> all = {options_.program, step};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const Result<ProgramEnd> end = run_program(all, log_, options_.timeout);
    if (!end && end.error().code == ErrorCode::NotFound)
      return fail(ErrorCode::NotFound, text(end.error().message, "; markerless calibration needs COLMAP: install the package 'colmap'"));
    if (!end) return forward(end);
    if (end->signal != 0 || end->code != 0)
      return fail(ErrorCode::BadData, text("COLMAP's ", step, end->signal != 0 ? text(" was ended by signal ", end->signal) : text(" ended with code ", end->code),
                                           ": ", advice, " (", end_of_log(log_, 1), "; the log is ", log_.string(), ")"));
    return {};
  }

  std::string path(const char* name) const { return (workspace_ / name).string(); }
  std::string threads() const { return text(options_.threads > 0 ? options_.threads : default_threads()); }

 private:
  const MarkerlessOptions& options_;
  fs::path log_, workspace_;
};

constexpr const char* kWeak = "too little is seen by neighbouring cameras together; put something textured on the stage, bring cameras "
                              "closer together, or add pictures of a camera that is carried between them";

Result<void> prepare(const std::vector<MarkerlessPicture>& pictures, const fs::path& workspace) {
  if (pictures.size() < 2) return fail(ErrorCode::InvalidArgument, "markerless calibration needs pictures of two cameras or more");
  std::error_code error;
  if (fs::exists(workspace, error) && !fs::is_empty(workspace, error))
    return fail(ErrorCode::AlreadyExists, text(workspace.string(), ": holds something already; name a new folder"));
  std::set<std::string> serials;
  for (const MarkerlessPicture& p : pictures) {
    if (!is_usable_serial(p.serial) || !serials.insert(p.serial).second)
      return fail(ErrorCode::InvalidArgument, text("the serial '", p.serial, "' is there twice or cannot be a file name"));
    if (const Result<void> sound = check(p.model); !sound)
      return fail(ErrorCode::InvalidArgument, text("camera '", p.serial, "': ", sound.error().message));
    if (p.model.skew != 0) return fail(ErrorCode::Unsupported, text("camera '", p.serial, "': COLMAP has no skew"));
    if (!fs::is_regular_file(p.file, error)) return fail(ErrorCode::NotFound, text(p.file.string(), ": there is no such picture"));
  }
  for (const char* name : {"images", "sparse", "model"})
    if (Result<void> made = make_folder(workspace / name); !made) return made;
  for (const MarkerlessPicture& p : pictures) {
    fs::copy_file(p.file, workspace / "images" / (p.serial + p.file.extension().string()), error);
    if (error) return fail(ErrorCode::Io, text(p.file.string(), ": cannot be copied to ", workspace.string(), ": ", error.message()));
  }
  return {};
}

std::string image_name(const MarkerlessPicture& p) { return p.serial + p.file.extension().string(); }

Result<void> extract(const Colmap& colmap, const std::vector<MarkerlessPicture>& pictures, const fs::path& workspace) {
  // One call for each kind of camera: COLMAP takes one set of parameters a call.
  std::map<std::pair<std::string, std::string>, std::string> lists;
  for (const MarkerlessPicture& p : pictures) lists[colmap_camera(p.model)] += image_name(p) + "\n";
  for (const auto& [camera, names] : lists) {
    if (Result<void> ok = write_file(workspace / "list.txt", names); !ok) return ok;
    // Both of COLMAP's use_gpu flags must be 0 where there is no display.
    if (Result<void> ok = colmap.run("feature_extractor",
                                     {"--database_path", colmap.path("database.db"), "--image_path", colmap.path("images"), "--image_list_path",
                                      colmap.path("list.txt"), "--ImageReader.camera_model", camera.first, "--ImageReader.camera_params",
                                      camera.second, "--ImageReader.single_camera_per_image", "1", "--SiftExtraction.use_gpu", "0",
                                      "--SiftExtraction.num_threads", colmap.threads(),
                                      "--SiftExtraction.peak_threshold", "0.003"},
                                     "are the pictures whole?");
        !ok)
      return ok;
  }
  return {};
}

Result<ForeignRig> largest_model(const Colmap& colmap, const fs::path& workspace, ColmapPoints& points) {
  std::optional<ForeignRig> best;
  std::error_code error;
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(workspace / "sparse", error)) folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  for (const fs::path& folder : folders) {
    const fs::path written = workspace / "model" / folder.filename();
    if (Result<void> made = make_folder(written); !made) return forward(made);
    if (Result<void> ok = colmap.run("model_converter", {"--input_path", folder.string(), "--output_path", written.string(), "--output_type", "TXT"},
                                     "is the disk full?");
        !ok)
      return forward(ok);
    Result<ForeignRig> rig = read_colmap(written);
    if (!rig) return rig;
    if (best && best->rig.cameras.size() >= rig->rig.cameras.size()) continue;
    const Result<std::string> bytes = read_file(written / "points3D.txt");
    if (!bytes) return forward(bytes);
    Result<ColmapPoints> parsed = parse_colmap_points(*bytes, (written / "points3D.txt").string());
    if (!parsed) return forward(parsed);
    points = *std::move(parsed);
    best = *std::move(rig);
  }
  if (!best) return fail(ErrorCode::BadData, text("COLMAP found no model: ", kWeak));
  return *std::move(best);
}

}  // namespace

Result<ColmapPoints> parse_colmap_points(std::string_view bytes, std::string_view name) {
  ColmapPoints result;
  std::map<int, int> images;
  long long seen = 0;
  double error_sum = 0;
  int line_number = 0;
  while (!bytes.empty()) {
    ++line_number;
    const std::size_t end = std::min(bytes.find('\n'), bytes.size());
    const std::string_view line = bytes.substr(0, end);
    bytes.remove_prefix(std::min(end + 1, bytes.size()));
    std::vector<std::string_view> words;
    for (std::size_t at = line.find_first_not_of(" \t\r"); at != line.npos; at = line.find_first_not_of(" \t\r", at)) {
      const std::size_t stop = std::min(line.find_first_of(" \t\r", at), line.size());
      words.push_back(line.substr(at, stop - at));
      at = stop;
    }
    if (words.empty() || words[0].starts_with('#')) continue;
    auto bad = [&](const char* what) { return fail(ErrorCode::BadData, text(name, ": line ", line_number, ": ", what)); };
    // POINT3D_ID X Y Z R G B ERROR, then pairs IMAGE_ID POINT2D_IDX.
    if (words.size() < 12 || words.size() % 2 != 0) return bad("a point needs its place, colour, error and at least two observations");
    const std::optional<double> error = parse_number(words[7]);
    if (!error || !std::isfinite(*error) || *error < 0) return bad("the error is no number");
    std::set<int> here;
    for (std::size_t i = 8; i < words.size(); i += 2) {
      const std::optional<long> image = parse_integer(words[i]);
      if (!image || *image < 0 || *image > 1'000'000'000) return bad("an image id is no number");
      here.insert(static_cast<int>(*image));
    }
    ++result.points;
    error_sum += *error;
    seen += static_cast<long long>(here.size());
    for (const int image : here) ++images[image];
  }
  if (result.points == 0) return fail(ErrorCode::BadData, text(name, ": there are no points"));
  result.mean_track = static_cast<double>(seen) / result.points;
  result.mean_error = error_sum / result.points;
  result.of_image.assign(images.begin(), images.end());
  return result;
}

Result<MarkerlessResult> calibrate_markerless(const std::vector<MarkerlessPicture>& pictures, const fs::path& workspace,
                                              const MarkerlessOptions& options) {
  if (const Result<void> ready = prepare(pictures, workspace); !ready) return forward(ready);
  const Colmap colmap(options, workspace);
  if (const Result<void> ok = extract(colmap, pictures, workspace); !ok) return forward(ok);
  if (const Result<void> ok = colmap.run("exhaustive_matcher", {"--database_path", colmap.path("database.db"), "--SiftMatching.use_gpu", "0",
                                                               "--SiftMatching.num_threads", colmap.threads(), "--SiftMatching.guided_matching", "1"}, kWeak);
      !ok)
    return forward(ok);
  // One thread, and intrinsics as they were given: the same pictures give the same rig.
  if (const Result<void> ok = colmap.run("mapper", {"--database_path", colmap.path("database.db"), "--image_path", colmap.path("images"), "--output_path",
                                                   colmap.path("sparse"), "--Mapper.ba_refine_focal_length", "0", "--Mapper.ba_refine_principal_point",
                                                   "0", "--Mapper.ba_refine_extra_params", "0", "--Mapper.num_threads", "1", "--Mapper.filter_max_reproj_error", "2"}, kWeak);
      !ok)
    return forward(ok);
  ColmapPoints points;
  const Result<ForeignRig> model = largest_model(colmap, workspace, points);
  if (!model) return forward(model);

  MarkerlessResult result{.rig = {}, .points = points.points, .mean_track = points.mean_track, .rms_px = points.mean_error};
  std::string missing;
  for (const MarkerlessPicture& p : pictures) {
    const auto found = std::find(model->image_names.begin(), model->image_names.end(), image_name(p));
    if (found == model->image_names.end()) {
      missing += (missing.empty() ? "'" : ", '") + p.serial + "'";
      continue;
    }
    RigCamera camera = model->rig.cameras[static_cast<std::size_t>(found - model->image_names.begin())];
    camera.serial = p.serial;
    camera.model = p.model;
    result.rig.cameras.push_back(std::move(camera));
  }
  if (!missing.empty())
    return fail(ErrorCode::BadData, text("COLMAP placed ", result.rig.cameras.size(), " of ", pictures.size(), " cameras, not ", missing, ": ", kWeak));
  if (points.mean_track < options.least_track)
    return fail(ErrorCode::BadData, text("a point is seen by ", std::round(10 * points.mean_track) / 10, " cameras on average, and by ", options.least_track,
                                         " at least it should be: poses could be off although the reprojection error is ",
                                         std::round(100 * points.mean_error) / 100, " px; ", kWeak));
  for (const auto& [image, count] : points.of_image)
    if (count < options.least_points)
      return fail(ErrorCode::BadData, text("one camera shows only ", count, " points: ", kWeak));
  return result;
}

Result<Rig> scale_to(Rig rig, const std::string& serial_a, const std::string& serial_b, double metres) {
  const int a = camera_index(rig, serial_a), b = camera_index(rig, serial_b);
  if (a < 0 || b < 0) return fail(ErrorCode::NotFound, text("the rig has no camera '", a < 0 ? serial_a : serial_b, "'"));
  const double apart = (rig.cameras[static_cast<std::size_t>(a)].cam_from_world.center() -
                        rig.cameras[static_cast<std::size_t>(b)].cam_from_world.center()).norm();
  if (!(metres > 0) || !std::isfinite(metres) || !(apart > 0))
    return fail(ErrorCode::InvalidArgument, text("cameras '", serial_a, "' and '", serial_b, "' cannot be ", metres, " m apart"));
  for (RigCamera& camera : rig.cameras) camera.cam_from_world.translation *= metres / apart;
  return rig;
}

}  // namespace floatstage
