#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "core/file.h"
#include "core/text.h"
#include "pipeline/calibrate/session_draft.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr double kUsualSquare = 0.03;     // metres: what is assumed of a board that nobody measured
constexpr std::size_t kFewPictures = 10;  // of a camera: none can be kept back to check with

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
    std::string s = usable_serial(m.name);
    while (!once.insert(s).second) s += "_";
    serials.push_back(s);
  }
  return {serials, false};
}

// The board with its squares as large as they are said to be.
Result<calib::TargetDesign> sized(SessionDraft& d, const FoundBoard& board) {
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
Result<bool> taken_alone(SessionDraft& d, const MediaSet& set, bool poses_known) {
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

}  // namespace

std::optional<double> rate_of_time_stamps(const fs::path& table) {
  const Result<std::string> bytes = read_file(table);
  if (!bytes) return std::nullopt;
  std::istringstream lines(*bytes);
  std::map<std::string, std::vector<double>> times;
  int camera = -1, time = -1;
  for (std::string line; std::getline(lines, line);) {
    if (line.ends_with('\r')) line.pop_back();
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

Result<void> draft_board(SessionDraft& d, const FoundBoard& board) {
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
      if (const std::optional<double> rate = rate_of_time_stamps(d.survey.time_stamps)) {
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
  if (known) d.known("compare", alone ? "fixed" : "compare");
  return {};
}

}  // namespace floatstage::pipeline
