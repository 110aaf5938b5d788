#include "pipeline/import/media_files.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <set>

#include "core/text.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

enum class Kind { Other, Picture, Video };

Kind kind_of(const fs::path& file) {
  static constexpr std::array kPictures{".png",  ".jpg", ".jpeg", ".bmp", ".tif", ".tiff",
                                        ".webp", ".ppm", ".pgm",  ".exr", ".dpx"};
  static constexpr std::array kVideos{".mp4", ".mov",  ".avi", ".mkv",  ".webm", ".m4v",
                                      ".mpg", ".mpeg", ".mts", ".m2ts", ".ts",   ".y4m"};
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (std::find(kPictures.begin(), kPictures.end(), extension) != kPictures.end()) return Kind::Picture;
  if (std::find(kVideos.begin(), kVideos.end(), extension) != kVideos.end()) return Kind::Video;
  return Kind::Other;
}

// Names in a folder, hidden ones left out, in natural order.
Result<std::vector<fs::path>> list(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> entries;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (it->path().filename().string().front() != '.') entries.push_back(it->path());
  if (error)
    return fail(error == std::errc::no_such_file_or_directory ? ErrorCode::NotFound : ErrorCode::Io,
                text("cannot list the folder ", folder.string(), ": ", error.message(),
                     "; say where the pictures are"));
  std::sort(entries.begin(), entries.end(), [](const fs::path& a, const fs::path& b) {
    return natural_less(a.filename().string(), b.filename().string());
  });
  return entries;
}

std::vector<fs::path> pictures_in(const fs::path& folder) {
  Result<std::vector<fs::path>> entries = list(folder);
  if (!entries) return {};
  std::erase_if(*entries, [](const fs::path& p) { return kind_of(p) != Kind::Picture; });
  return *entries;
}

}  // namespace

CameraMedia media_of(const fs::path& entry) {
  std::error_code error;
  if (fs::is_directory(entry, error)) return {{}, pictures_in(entry)};
  if (kind_of(entry) == Kind::Video) return {entry, {}};
  if (kind_of(entry) == Kind::Picture) return {{}, {entry}};
  return {};
}

namespace {

// "cam1" fits cam1/, cam1.png and cam1.mp4; "cam1.png" also fits cam1.mp4 (another kind of the same camera's
// file).
bool fits(const fs::path& entry, const std::string& wanted) {
  const std::string name = entry.filename().string(), stem = entry.stem().string();
  if (name == wanted || stem == wanted) return true;
  return kind_of(wanted) != Kind::Other && fs::path(wanted).stem().string() == stem;
}

bool ends_with_serial(const fs::path& entry, const std::string& serial) {
  const std::string stem = entry.stem().string();
  return kind_of(entry) == Kind::Video && (stem.ends_with("_" + serial) || stem.ends_with("-" + serial));
}

// The only entry for which `fitting` holds and that has pictures; an exact name counts more than a stem.
template <class Fitting>
Result<fs::path> only(const std::vector<fs::path>& entries, const std::string& serial,
                      const Fitting& fitting) {
  fs::path found;
  for (const fs::path& entry : entries) {
    if (!fitting(entry) || media_of(entry).empty()) continue;
    if (!found.empty())
      return fail(ErrorCode::InvalidArgument,
                  text("camera '", serial, "': both ", found.string(), " and ", entry.string(),
                       " could be its pictures; leave only one of them there"));
    found = entry;
  }
  return found;
}

class Search {
 public:
  Search(fs::path folder, std::vector<fs::path> entries, const calib::ForeignRig& foreign)
      : folder_(std::move(folder)), entries_(std::move(entries)), foreign_(foreign) {
    for (const std::string& image : foreign.image_names)
      ++cameras_in_[fs::path(image).parent_path().string()];
  }

  Result<CameraMedia> find(std::size_t camera) {
    const std::string &image = foreign_.image_names[camera], &serial = foreign_.rig.cameras[camera].serial;
    std::error_code error;
    const fs::path named = fs::path(image).is_absolute() ? fs::path() : folder_ / image;
    if (!named.empty() && fs::is_regular_file(named, error)) {
      const fs::path parent = fs::path(image).parent_path();
      used_.insert(folder_ / *fs::path(image).begin());
      // One calibrated picture in a folder of its own stands for the camera, and the folder holds its film.
      if (!parent.empty() && cameras_in_[parent.string()] == 1 && !foreign_.one_picture_each)
        return CameraMedia{{}, pictures_in(folder_ / parent)};
      return media_of(named);
    }
    const fs::path image_folder = fs::path(image).parent_path();
    for (const std::string& wanted :
         {image, serial, cameras_in_[image_folder.string()] == 1 ? image_folder.string() : image}) {
      if (wanted.empty()) continue;
      const Result<fs::path> found =
          only(entries_, serial, [&](const fs::path& e) { return fits(e, wanted); });
      if (!found) return forward(found);
      if (!found->empty()) return take(*found);
    }
    const Result<fs::path> found =
        only(entries_, serial, [&](const fs::path& e) { return ends_with_serial(e, serial); });
    if (!found) return forward(found);
    return found->empty() ? CameraMedia{} : take(*found);
  }

  std::vector<std::string> unused() const {
    std::vector<std::string> names;
    for (const fs::path& entry : entries_)
      if (!used_.contains(entry) && !media_of(entry).empty()) names.push_back(entry.filename().string());
    return names;
  }

 private:
  CameraMedia take(const fs::path& entry) {
    used_.insert(entry);
    return media_of(entry);
  }

  const fs::path folder_;
  const std::vector<fs::path> entries_;
  const calib::ForeignRig& foreign_;
  std::map<std::string, int> cameras_in_;  // how many cameras have their image in this folder
  std::set<fs::path> used_;
};

}  // namespace

bool natural_less(const std::string& a, const std::string& b) {
  const auto digit = [](const std::string& s, std::size_t i) {
    return i < s.size() && std::isdigit(static_cast<unsigned char>(s[i]));
  };
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (!digit(a, i) || !digit(b, j)) {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
      continue;
    }
    const auto number = [&](const std::string& s,
                            std::size_t& k) {  // without leading zeros, as text of any length
      while (digit(s, k) && s[k] == '0') ++k;
      const std::size_t begin = k;
      while (digit(s, k)) ++k;
      return s.substr(begin, k - begin);
    };
    const std::string x = number(a, i), y = number(b, j);
    if (x.size() != y.size()) return x.size() < y.size();
    if (x != y) return x < y;
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;  // 01 and 1: any fixed order
}

Result<MediaSearch> find_media(const fs::path& folder, const calib::ForeignRig& foreign) {
  Result<std::vector<fs::path>> entries = list(folder);
  if (!entries) return forward(entries);
  Search search(folder, std::move(*entries), foreign);
  MediaSearch result;
  for (std::size_t i = 0; i < foreign.rig.cameras.size(); ++i) {
    Result<CameraMedia> media = search.find(i);
    if (!media) return forward(media);
    result.cameras.push_back(std::move(*media));
  }
  result.unused = search.unused();
  return result;
}

}  // namespace floatstage::pipeline
