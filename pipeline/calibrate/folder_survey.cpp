#include "pipeline/calibrate/folder_survey.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>

#include "core/file_presence.h"
#include "core/text.h"
#include "pipeline/import/media_files.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr int kDeepest = 4;
constexpr std::size_t kMostFiles = 200'000;

std::string lower(std::string s) {
  for (char& c : s) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return s;
}

bool ends_like(const fs::path& file, std::initializer_list<const char*> extensions) {
  const std::string own = lower(file.extension().string());
  return std::any_of(extensions.begin(), extensions.end(), [&](const char* e) { return own == e; });
}

bool is_picture(const fs::path& f) {
  return ends_like(f, {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp"});
}
bool is_video(const fs::path& f) {
  return ends_like(f, {".mp4", ".mov", ".avi", ".mkv", ".webm", ".m4v", ".mpg", ".mpeg", ".mts", ".y4m"});
}

// Mattes are no pictures of a scene.
bool is_matte(const fs::path& p) {
  const std::string name = lower(p.filename().string());
  return name.find("mask") != std::string::npos || name.find("matte") != std::string::npos;
}

struct Natural {
  bool operator()(const fs::path& a, const fs::path& b) const { return natural_less(a.string(), b.string()); }
};
using ByFolder = std::map<fs::path, std::vector<fs::path>, Natural>;

struct Listing {
  ByFolder pictures, videos;
  std::vector<fs::path> others;
  std::vector<std::string> left_out;
};

Result<Listing> list(const fs::path& folder) {
  Listing out;
  std::error_code error;
  std::size_t files = 0;
  std::map<fs::path, int, Natural> mattes;  // pictures that are mattes by their own names, in each folder
  fs::recursive_directory_iterator it(folder, fs::directory_options::skip_permission_denied, error), end;
  for (; !error && it != end; it.increment(error)) {
    const fs::path& p = it->path();
    const bool inner = is_folder(p);
    if (p.filename().string().starts_with('.') || is_matte(p) || (inner && it.depth() + 1 >= kDeepest)) {
      if (inner) it.disable_recursion_pending();
      if (inner && is_matte(p)) out.left_out.push_back(text(p.string(), " holds mattes, by its name"));
      if (!inner && is_matte(p) && is_picture(p)) ++mattes[p.parent_path()];
      continue;
    }
    if (inner) continue;
    if (++files > kMostFiles)
      return fail(ErrorCode::BadData, text(folder.string(), ": more than ", kMostFiles,
                                           " files; name the folder of the calibration itself"));
    if (is_picture(p))
      out.pictures[p.parent_path()].push_back(p);
    else if (is_video(p))
      out.videos[p.parent_path()].push_back(p);
    else
      out.others.push_back(p);
  }
  if (error)
    return fail(error == std::errc::no_such_file_or_directory ? ErrorCode::NotFound : ErrorCode::Io,
                text(folder.string(), ": cannot be listed: ", error.message()));
  for (const auto& [where, count] : mattes)
    out.left_out.push_back(text(count, count == 1 ? " picture in " : " pictures in ", where.string(),
                                count == 1 ? " is a matte, by its name" : " are mattes, by their names"));
  for (ByFolder* lists : {&out.pictures, &out.videos})
    for (auto& [where, paths] : *lists) std::sort(paths.begin(), paths.end(), Natural());
  std::sort(out.others.begin(), out.others.end(), Natural());
  return out;
}

// Pictures of one folder by how their names begin.
MediaSet by_names(const fs::path& folder, const std::vector<fs::path>& pictures) {
  std::map<std::string, std::vector<fs::path>> groups;
  for (const fs::path& p : pictures) groups[name_before_number(p.stem().string())].push_back(p);
  MediaSet set{MediaSet::Kind::Names, folder, {}};
  const bool apart = groups.size() > 1 && std::all_of(groups.begin(), groups.end(), [](const auto& g) {
                       return g.second.size() > 1 && !g.first.empty();
                     });
  if (apart) {
    for (auto& [name, stills] : groups) set.media.push_back({name, {}, std::move(stills)});
  } else {
    set.kind = MediaSet::Kind::Pictures;
    set.media.push_back({folder.filename().string(), {}, pictures});
  }
  return set;
}

std::vector<MediaSet> sets_of(const Listing& listing) {
  std::vector<MediaSet> sets;
  for (const auto& [folder, videos] : listing.videos) {
    MediaSet set{MediaSet::Kind::Videos, folder, {}};
    for (const fs::path& v : videos) set.media.push_back({v.stem().string(), v, {}});
    sets.push_back(std::move(set));
  }
  ByFolder beside;  // folders of pictures, by the folder that they lie in
  for (const auto& [folder, pictures] : listing.pictures) beside[folder.parent_path()].push_back(folder);
  for (const auto& [parent, folders] : beside) {
    MediaSet set{MediaSet::Kind::Folders, parent, {}};
    for (const fs::path& f : folders) {
      const std::vector<fs::path>& stills = listing.pictures.at(f);
      if (folders.size() == 1)
        set = by_names(f, stills);
      else
        set.media.push_back({f.filename().string(), {}, stills});
    }
    sets.push_back(std::move(set));
  }
  std::stable_sort(sets.begin(), sets.end(),
                   [](const MediaSet& a, const MediaSet& b) { return a.media.size() > b.media.size(); });
  return sets;
}

// Of all files and folders that a format recognises, the calibration that reads and has most cameras.
void find_calibration(const fs::path& folder, const Listing& listing, FolderSurvey& out) {
  std::vector<fs::path> places = listing.others;
  places.push_back(folder);
  for (const auto& [where, pictures] : listing.pictures) places.push_back(where);
  for (const fs::path& place : places) {
    const Result<const calib::RigFormat*> format = calib::rig_format(calib::kAnyRigFormat, place);
    if (!format) continue;
    const calib::RigFile file{std::string((*format)->name), place, calib::kMetresPerUnit};
    Result<calib::ForeignRig> rig = calib::read_rig(file);
    if (!rig || rig->rig.cameras.size() <= out.rig.rig.cameras.size()) continue;
    out.calibration = file;
    out.calibration_format = std::string((*format)->title);
    out.rig = *std::move(rig);
  }
}

}  // namespace

std::string name_before_number(const std::string& stem) {
  static constexpr std::array kFillers{"frame", "image", "img", "picture", "photo", "shot", "pic"};
  std::string s = stem;
  const auto drop = [&](auto what) {
    while (!s.empty() && what(static_cast<unsigned char>(s.back()))) s.pop_back();
  };
  const auto is_joint = [](unsigned char c) { return c == '_' || c == '-' || c == '.' || c == ' '; };
  drop([](unsigned char c) { return !std::isdigit(c); });
  drop([](unsigned char c) { return std::isdigit(c) != 0; });
  drop(is_joint);
  for (const char* filler : kFillers)
    if (lower(s).ends_with(filler)) {
      s.resize(s.size() - std::string(filler).size());
      drop(is_joint);
      break;
    }
  return s;
}

Result<FolderSurvey> survey_folder(const fs::path& folder) {
  if (!is_folder(folder))
    return fail(ErrorCode::NotFound, text(folder.string(), ": there is no such folder"));
  Result<Listing> listing = list(folder);
  if (!listing) return forward(listing);
  FolderSurvey out;
  out.sets = sets_of(*listing);
  out.left_out = std::move(listing->left_out);
  if (out.sets.empty()) {
    std::string but;
    for (const std::string& sentence : out.left_out) but += "; " + sentence;
    return fail(ErrorCode::NotFound, text(folder.string(), ": holds neither pictures nor videos, ", kDeepest,
                                          " levels deep", but, "; name the folder where they lie"));
  }
  find_calibration(folder, *listing, out);
  for (const fs::path& p : listing->others) {
    const std::string name = lower(p.filename().string());
    if (name == "charuco.toml" || (out.board.empty() && ends_like(p, {".pdf", ".svg"}))) out.board = p;
    if (name == "timestamps.csv") out.time_stamps = p;
  }
  return out;
}

}  // namespace floatstage::pipeline
