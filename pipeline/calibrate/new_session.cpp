#include "pipeline/calibrate/new_session.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "calib/exif_lens.h"
#include "core/file.h"
#include "core/text.h"
#include "pipeline/calibrate/board_search.h"
#include "pipeline/calibrate/session.h"
#include "pipeline/import/picture_stream.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr double kUsualSquare = 0.03;     // metres: what is assumed of a board that nobody measured
constexpr std::size_t kFewPictures = 10;  // of a camera: none can be kept back to check with

// The session as it grows.
struct Draft {
  const FolderSurvey& survey;
  const NewSessionOptions& options;
  fs::path written_to;
  NewSession out;
  std::string head, tables, cameras;

  std::string quoted(const std::string& s) const {
    std::string q = "\"";
    for (const char c : s) q += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
    return q + "\"";
  }
  std::string path(const fs::path& p) const {
    std::error_code error;
    const fs::path from = fs::weakly_canonical(written_to, error), to = fs::weakly_canonical(p, error);
    const fs::path relative = to.lexically_relative(from);
    return quoted((relative.empty() ? to : relative).string());
  }
  std::string paths(const std::vector<fs::path>& list) const {
    if (list.size() == 1) return path(list.front());
    std::string all;
    for (const fs::path& p : list) all += (all.empty() ? "" : ", ") + path(p);
    return "[" + all + "]";
  }
  void found(std::string sentence) { out.found.push_back(std::move(sentence)); }
  void assume(std::string sentence) { out.assumed.push_back(std::move(sentence)); }
  void camera(const std::string& serial, const std::string& key, const std::string& value) {
    cameras += text("\n[[cameras]]\nserial = ", quoted(serial), "\n", key, " = ", value, "\n");
    ++out.cameras;
  }
};

std::string usable(std::string name) {
  for (char& c : name)
    if (!is_usable_serial(std::string("a") + c)) c = '_';
  return is_usable_serial(name) ? name : "cam_" + name;
}

// The calibrated camera that a name means: the same, or the only one whose serial is a part of it.
std::optional<std::string> serial_for(const std::string& name, const Rig& rig) {
  if (camera_index(rig, name) >= 0) return name;
  std::optional<std::string> found;
  for (const RigCamera& c : rig.cameras)
    if (name.find(c.serial) != std::string::npos) {
      if (found) return std::nullopt;
      found = c.serial;
    }
  return found;
}

// Names of a set's cameras: as the calibration has them where it has them all, else their own.
std::pair<std::vector<std::string>, bool> serials_of(const MediaSet& set, const Rig& rig) {
  std::vector<std::string> serials;
  std::set<std::string> once;
  for (const SurveyedMedia& m : set.media)
    if (const std::optional<std::string> s = serial_for(m.name, rig); s && once.insert(*s).second)
      serials.push_back(*s);
  if (serials.size() == set.media.size()) return {serials, true};
  serials.clear();
  once.clear();
  for (const SurveyedMedia& m : set.media) {
    std::string s = usable(m.name);
    while (!once.insert(s).second) s += "_";
    serials.push_back(s);
  }
  return {serials, false};
}

// Pictures a second, by a table with columns cam_id and frame_time (seconds), as Caliscope writes it.
std::optional<double> rate_of(const fs::path& table) {
  const Result<std::string> bytes = read_file(table);
  if (!bytes) return std::nullopt;
  std::istringstream lines(*bytes);
  std::map<std::string, std::vector<double>> times;
  int camera = -1, time = -1;
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    if (camera < 0) {
      for (std::size_t i = 0; i < cells.size(); ++i) {
        if (cells[i] == "cam_id") camera = static_cast<int>(i);
        if (cells[i] == "frame_time") time = static_cast<int>(i);
      }
      if (camera < 0 || time < 0) return std::nullopt;
      continue;
    }
    if (cells.size() <= static_cast<std::size_t>(std::max(camera, time))) return std::nullopt;
    const double t = std::atof(cells[static_cast<std::size_t>(time)].c_str());
    times[cells[static_cast<std::size_t>(camera)]].push_back(t);
  }
  if (times.empty() || times.begin()->second.size() < 2) return std::nullopt;
  const auto [first, last] = std::minmax_element(times.begin()->second.begin(), times.begin()->second.end());
  const double rate = static_cast<double>(times.begin()->second.size() - 1) / (*last - *first);
  if (!std::isfinite(rate) || !(rate > 0)) return std::nullopt;
  return std::round(100 * rate) / 100;
}

void add_known(Draft& d, const char* intrinsics, const char* poses) {
  const calib::RigFile& file = *d.survey.calibration;
  d.tables += text("\n[known]\nfile = ", d.path(file.path), "\nformat = ", d.quoted(file.format),
                   "\nintrinsics = \"", intrinsics, "\"\nposes = \"", poses, "\"\n");
  const Result<const calib::RigFormat*> format = calib::rig_format(file.format, file.path);
  if (!format || (*format)->states_unit) return;
  d.tables += text("metres_per_unit = ", file.metres_per_unit, "\n");
  d.assume(text("a unit of ", file.path.string(), " is ", file.metres_per_unit,
                " m: the format states none (metres_per_unit in [known])"));
}

// The board with its squares as large as they are said to be.
Result<calib::TargetDesign> sized(Draft& d, const FoundBoard& board) {
  if (board.square_is_known) return board.design;
  double square = d.options.square.value_or(0);
  if (!(square > 0) && d.options.ask)
    square = d.options
                 .ask(text("The pictures show: ", calib::to_text(board.design),
                           "\nHow long is the side of a square (of a tag), in millimetres?"))
                 .value_or(0);
  if (!(square > 0)) {
    square = kUsualSquare;
    d.assume(text("a square of the board is ", 1e3 * square,
                  " mm: no picture shows how large it is. All lengths follow it: measure it and correct "
                  "'target', or give --square"));
  }
  calib::TargetDesign design = board.design;
  if (auto* c = std::get_if<calib::Chessboard>(&design)) c->square = square;
  if (auto* c = std::get_if<calib::CharucoBoard>(&design)) c->marker *= square, c->square = square;
  if (auto* c = std::get_if<calib::AprilTagGrid>(&design)) c->tag = square, c->gap *= square;
  // Round figures, as a person would write them.
  if (auto* c = std::get_if<calib::CharucoBoard>(&design)) c->marker = std::round(1e5 * c->marker) / 1e5;
  if (Result<void> ok = calib::check(design); !ok)
    return fail(ok.error().code, text("the board that the pictures seem to show is none: ",
                                      ok.error().message, "; give it as --target"));
  return design;
}

bool says_intrinsics(const fs::path& p) {
  std::string s = p.string();
  std::transform(s.begin(), s.end(), s.begin(), [](unsigned char c) { return std::tolower(c); });
  return s.find("intrins") != std::string::npos || s.find("alone") != std::string::npos;
}

// How stills of a board belong together: each camera's own, or the same instants.
Result<bool> taken_alone(Draft& d, const MediaSet& set, bool poses_known) {
  if (d.options.alone || d.options.at_once) return d.options.alone;
  const std::size_t count = set.media.front().stills.size();
  const bool equal = std::all_of(set.media.begin(), set.media.end(),
                                 [&](const SurveyedMedia& m) { return m.stills.size() == count; });
  if (set.media.size() == 1) return false;
  if (says_intrinsics(set.folder) && poses_known) {
    d.assume(text("each camera took its pictures of the board for itself: they lie in ", set.folder.string(),
                  "; poses are the known ones (--at-once says otherwise)"));
    return true;
  }
  if (equal) {
    d.assume(
        "pictures of all cameras that are in the same place of their order were taken at the same instant: "
        "there are equally many (--alone says otherwise)");
    return false;
  }
  if (poses_known) {
    d.assume("each camera took its pictures of the board for itself: there are not equally many");
    return true;
  }
  return fail(
      ErrorCode::BadData,
      text(set.folder.string(),
           ": the cameras have unequal numbers of pictures, so they are not of the same "
           "instants, and nothing known says where the cameras stand; keep the pictures that all cameras "
           "took at once, or calibrate each folder by itself"));
}

Result<void> draft_board(Draft& d, const FoundBoard& board) {
  const MediaSet& set = d.survey.sets[board.set];
  const Result<calib::TargetDesign> design = sized(d, board);
  if (!design) return forward(design);
  const auto [serials, named] = serials_of(set, d.survey.rig.rig);
  const bool known = d.survey.calibration && named;
  const bool videos = set.kind == MediaSet::Kind::Videos;
  d.found(text("a board in ", board.pictures, " of ", board.looked_at, " pictures that were looked at in ",
               set.folder.string(), ", ", board.how));
  d.head = text("target = ", d.quoted(calib::to_text(*design)), "\n");
  bool alone = false;
  if (!videos) {
    const Result<bool> taken = taken_alone(d, set, known);
    if (!taken) return forward(taken);
    alone = *taken;
  } else if (set.media.size() > 1) {
    d.tables += "\n[options]\ntime_offsets = true\n";
    d.assume(
        "the cameras had no common trigger: videos do not say; time_offsets = true finds lags, and costs "
        "little "
        "where there are none");
    if (!d.survey.time_stamps.empty() && d.survey.time_stamps.parent_path() == set.folder)
      if (const std::optional<double> rate = rate_of(d.survey.time_stamps)) {
        d.head += text("frame_rate = ", *rate, "\n");
        d.found(text(d.survey.time_stamps.string(), " says ", *rate, " pictures a second"));
      }
  }
  std::size_t fewest = videos ? kFewPictures : set.media.front().stills.size();
  for (std::size_t i = 0; i < set.media.size(); ++i) {
    const SurveyedMedia& m = set.media[i];
    if (videos)
      d.camera(serials[i], "video", d.path(m.video));
    else if (set.kind == MediaSet::Kind::Folders)
      d.camera(serials[i], alone ? "alone" : "images", d.path(m.stills.front().parent_path()));
    else
      d.camera(serials[i], alone ? "alone" : "images", d.paths(m.stills));
    if (!videos) fewest = std::min(fewest, m.stills.size());
  }
  if (fewest < kFewPictures) {
    d.tables += "\n[options]\nholdout_every = 0\n";
    d.assume(text("no picture is kept back to check with: the fewest of a camera are ", fewest));
  }
  if (known) add_known(d, "compare", alone ? "fixed" : "compare");
  return {};
}

// The picture of a calibrated camera among all that lie there.
std::optional<fs::path> picture_of(const std::string& serial, const std::string& image,
                                   const FolderSurvey& survey) {
  for (const MediaSet& set : survey.sets)
    for (const SurveyedMedia& m : set.media) {
      if (m.name == serial && !m.stills.empty() && set.kind != MediaSet::Kind::Pictures)
        return m.stills.front();
      for (const fs::path& p : m.stills)
        if (p.filename() == fs::path(image).filename() || p.stem() == serial || p.filename() == serial)
          return p;
    }
  return std::nullopt;
}

// Known cameras and a picture of each: are they still where they are said to be?
bool draft_known_scene(Draft& d) {
  if (!d.survey.calibration) return false;
  const Rig& rig = d.survey.rig.rig;
  std::vector<std::pair<std::string, fs::path>> pictures;
  for (std::size_t i = 0; i < rig.cameras.size(); ++i)
    if (const auto p = picture_of(rig.cameras[i].serial, d.survey.rig.image_names[i], d.survey))
      pictures.emplace_back(rig.cameras[i].serial, *p);
  if (pictures.size() < 2) return false;
  d.found(text("no board in any picture that was looked at, and a picture of ", pictures.size(),
               " of the calibrated cameras"));
  d.assume(
      "the calibration is nearly right: its lenses are kept, its poses are where the solver starts, and the "
      "report says which camera has moved");
  d.tables += "\n[markerless]\n";
  add_known(d, "fixed", "start");
  for (const auto& [serial, file] : pictures) d.camera(serial, "scene", d.path(file));
  return true;
}

// Pictures of a scene and nothing else: every picture is a camera.
Result<void> draft_unknown_scene(Draft& d) {
  std::vector<std::pair<std::string, fs::path>> pictures;
  const MediaSet* chosen = nullptr;
  std::size_t most = 0;
  for (const MediaSet& set : d.survey.sets) {
    if (set.kind == MediaSet::Kind::Videos) continue;
    const std::size_t n =
        set.kind == MediaSet::Kind::Pictures ? set.media.front().stills.size() : set.media.size();
    if (n > most) most = n, chosen = &set;
  }
  if (!chosen || most < 3)
    return fail(
        ErrorCode::NotFound,
        "no picture that was looked at shows a board, there is no calibration of another program, and there "
        "are not three pictures of a scene; show a board to the cameras, or say which it is with --target");
  if (chosen->kind == MediaSet::Kind::Pictures)
    for (const fs::path& p : chosen->media.front().stills)
      pictures.emplace_back(usable(p.stem().string()), p);
  else
    for (const SurveyedMedia& m : chosen->media) pictures.emplace_back(usable(m.name), m.stills.front());
  const bool one_folder = chosen->kind == MediaSet::Kind::Pictures;
  std::string camera;
  if (const Result<std::string> bytes = read_file(pictures.front().second))
    if (const calib::ExifLens lens = calib::exif_lens(*bytes); lens.focal_per_width) {
      d.found(text("EXIF: ", lens.camera.empty() ? "a camera" : lens.camera, ", focal length ",
                   std::round(100 * *lens.focal_per_width) / 100, " of the picture's longer side"));
      camera = lens.camera;
    }
  d.found(text("no board and no calibration; ", pictures.size(), " pictures of a scene in ",
               chosen->folder.string()));
  double metres = d.options.distance.value_or(0);
  if (!(metres > 0) && d.options.ask)
    metres = 1e-3 * 1e3 *
             d.options
                 .ask(text("How far apart are cameras '", pictures[0].first, "' and '", pictures[1].first,
                           "', in millimetres?"))
                 .value_or(0);
  if (!(metres > 0)) {
    metres = 1;
    d.assume(
        text("cameras '", pictures[0].first, "' and '", pictures[1].first,
             "' are 1 m apart: pictures do not show how large a scene is. Measure a distance between two "
             "cameras and correct 'between' and 'distance', or give --distance"));
  }
  d.assume(one_folder
               ? "all pictures are of one camera that was carried about, or of cameras alike, with one lens: "
                 "they lie in one folder (lens = \"separate\" says otherwise)"
               : "every camera has a lens of its own: they have folders of their own (lens = \"shared\" says "
                 "otherwise)");
  d.tables +=
      text("\n[markerless]\nlens = \"", one_folder ? "shared" : "separate", "\"\nbetween = [",
           d.quoted(pictures[0].first), ", ", d.quoted(pictures[1].first), "]\ndistance = ", metres, "\n");
  for (const auto& [serial, file] : pictures) d.camera(serial, "scene", d.path(file));
  return {};
}

std::string commented(const std::vector<std::string>& sentences) {
  std::string out;
  for (const std::string& s : sentences) out += "#   " + s + "\n";
  return out;
}

}  // namespace

Result<NewSession> draft_session(const fs::path& folder, const fs::path& written_to,
                                 const NewSessionOptions& options, Progress* watch) {
  std::optional<calib::TargetDesign> given;
  if (!options.target.empty()) {
    const Result<calib::TargetDesign> parsed = calib::parse_target(options.target);
    if (!parsed) return forward(parsed);
    given = *parsed;
  }
  const Result<FolderSurvey> survey = survey_folder(folder);
  if (!survey) return forward(survey);
  Draft d{*survey, options, written_to, {}, {}, {}, {}};
  if (survey->calibration)
    d.found(text("a calibration of ", survey->rig.rig.cameras.size(), " cameras, ",
                 survey->calibration_format, ": ", survey->calibration->path.string()));
  for (const std::string& sentence : survey->left_out) d.found(sentence + ", and was left out");
  const Result<std::optional<FoundBoard>> board = find_board(*survey, given, options.threads, watch);
  if (!board) return forward(board);
  if (*board) {
    if (Result<void> ok = draft_board(d, **board); !ok) return forward(ok);
  } else if (!draft_known_scene(d)) {
    if (Result<void> ok = draft_unknown_scene(d); !ok) return forward(ok);
  }
  d.out.toml = text("# Written by `floatstage calibrate new`.\n# Found:\n", commented(d.out.found),
                    "# Assumed:\n", d.out.assumed.empty() ? "#   nothing\n" : commented(d.out.assumed), "\n",
                    d.head, d.tables, d.cameras);
  return std::move(d.out);
}

}  // namespace floatstage::pipeline
