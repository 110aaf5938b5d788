#include "pipeline/import/contour_files.h"

#include <algorithm>
#include <set>

#include "core/file.h"
#include "core/png.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

// "cam0/000012.png" → "cam0/000012", whichever way its program writes folders.
std::string key_of(std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  return fs::path(name).lexically_normal().replace_extension().generic_string();
}

/// Contours by the names of their pictures, read when they are asked for.
class Index {
 public:
  static Result<Index> open(const fs::path& given, const ContourOptions& options) {
    Index index(given, options);
    std::error_code error;
    const Result<void> ok = fs::is_directory(given, error) ? index.list() : index.read_coco();
    if (!ok) return forward(ok);
    return index;
  }

  bool has(const std::string& key) const { return keys_.contains(key); }

  Result<PictureContours> read(const std::string& key) {
    unused_.erase(key);
    if (const auto picture = pictures_.find(key); picture != pictures_.end()) return picture->second;
    const fs::path file = given_ / (key + ".json");
    const Result<std::string> content = read_file(file);
    if (!content) return forward(content);
    return parse_labelme(*content, file.string(), options_);
  }

  /// Those whose names `fits`, in natural order.
  template <class Fits>
  std::vector<std::string> all(const Fits& fits) const {
    std::vector<std::string> out;
    for (const std::string& key : keys_)
      if (fits(key)) out.push_back(key);
    std::sort(out.begin(), out.end(), natural_less);
    return out;
  }

  const std::set<std::string>& unused() const { return unused_; }

 private:
  Index(fs::path given, const ContourOptions& options) : given_(std::move(given)), options_(options) {}

  Result<void> list() {
    std::error_code error;
    fs::recursive_directory_iterator it(given_, error), end;
    for (; !error && it != end; it.increment(error)) {
      if (it->path().filename().string().front() == '.') {
        it.disable_recursion_pending();
      } else if (it->path().extension() == ".json" && it->is_regular_file(error)) {
        keys_.insert(key_of(fs::relative(it->path(), given_, error).string()));
      }
    }
    if (error)
      return fail(ErrorCode::Io, text("cannot list the folder ", given_.string(), ": ", error.message()));
    unused_ = keys_;
    return {};
  }

  Result<void> read_coco() {
    const Result<std::string> content = read_file(given_);
    if (!content) return forward(content);
    Result<std::vector<PictureContours>> read = parse_coco(*content, given_.string(), options_);
    if (!read) return forward(read);
    for (PictureContours& picture : *read) {
      const std::string key = key_of(picture.picture);
      keys_.insert(key);
      pictures_.emplace(key, std::move(picture));
    }
    unused_ = keys_;
    return {};
  }

  fs::path given_;
  ContourOptions options_;
  std::set<std::string> keys_, unused_;
  std::map<std::string, PictureContours> pictures_;  // COCO's
};

/// What a picture's contours may be called, the likeliest first.
std::vector<std::string> names_for(const fs::path& picture, const std::string& serial, bool only_one) {
  const std::string stem = picture.stem().string(), folder = picture.parent_path().filename().string();
  std::vector<std::string> names{serial + "/" + stem, folder + "/" + stem, serial + "_" + stem,
                                 serial + "-" + stem};
  if (only_one) {
    names.push_back(stem);
    names.push_back(serial);
  }
  return names;
}

bool belongs_to(const std::string& key, const std::string& owner) {
  return fs::path(key).parent_path().filename() == owner || key.starts_with(owner + "_") ||
         key.starts_with(owner + "-");
}

std::string some(const std::set<std::string>& names) {
  std::string out;
  int shown = 0;
  for (const std::string& name : names) {
    if (++shown > 3) break;
    out += text(shown > 1 ? ", " : "", name);
  }
  return names.size() > 3 ? text(out, " and ", names.size() - 3, " more") : out;
}

bool in(const FrameRange& range, int picture) {
  return picture >= range.first && (!range.end || picture < *range.end) &&
         (picture - range.first) % range.step == 0;
}

}  // namespace

Result<ContourFiles> ContourFiles::find(const fs::path& given, const calib::ForeignRig& foreign,
                                        const std::vector<CameraMedia>& media, const FrameRange& range,
                                        const ContourOptions& options) {
  Result<Index> index = Index::open(given, options);
  if (!index) return forward(index);
  ContourFiles files;
  files.given_ = given;
  files.range_ = range;
  files.cameras_.resize(media.size());
  std::size_t shapes = 0, pictures = 0;
  std::set<std::string> without_subject;
  for (std::size_t c = 0; c < media.size(); ++c) {
    const std::string& serial = foreign.rig.cameras[c].serial;
    Camera& camera = files.cameras_[c];
    std::vector<std::string> keys;  // by the picture's number; empty: none
    if (!media[c].video.empty()) {
      const std::string stem = media[c].video.stem().string();
      keys = index->all([&](const std::string& k) { return belongs_to(k, serial) || belongs_to(k, stem); });
      camera.of_video = static_cast<int>(keys.size());
    }
    const bool only_one = media[c].stills.size() == 1;
    files.one_picture_.push_back(only_one);
    for (const fs::path& still : media[c].stills) {
      const std::vector<std::string> names = names_for(still, serial, only_one);
      const auto found =
          std::find_if(names.begin(), names.end(), [&](const auto& n) { return index->has(n); });
      keys.push_back(found == names.end() ? "" : *found);
    }
    for (std::size_t i = 0; i < keys.size(); ++i) {
      if (keys[i].empty() || !(only_one || in(range, static_cast<int>(i)))) continue;
      Result<PictureContours> read = index->read(keys[i]);
      if (!read) return forward(read);
      shapes += read->shapes.size();
      ++pictures;
      if (read->shapes.empty()) without_subject.insert(keys[i]);
      camera.pictures.emplace(static_cast<int>(i), std::move(*read));
    }
    if (camera.pictures.empty()) files.without_.push_back(serial);
  }
  if (pictures == 0)
    return fail(
        ErrorCode::NotFound,
        text(given.string(),
             ": there are no contours of any picture; give COCO's JSON file, or a folder of labelme's "
             "that are named as the pictures are (SERIAL/NAME.json)"));
  if (shapes == 0)
    return fail(ErrorCode::NotFound,
                text(given.string(), ": the contours of all ", pictures, " pictures are empty",
                     options.labels.empty() ? "" : "; see --contour-labels"));
  if (!without_subject.empty())
    files.notes_.push_back(text("the subject is not in ", without_subject.size(), " of ", pictures,
                                " pictures, by their contours: ", some(without_subject)));
  std::set<std::string> unused = index->unused();
  if (range.first > 0 || range.end || range.step > 1) unused.clear();  // of pictures that nobody asked for
  if (!unused.empty())
    files.notes_.push_back(
        text(unused.size(), " of the contours are of no picture and are left out: ", some(unused)));
  return files;
}

Result<void> ContourFiles::save(std::size_t camera, const RigCamera& rig_camera, int count,
                                const fs::path& take) const {
  const Camera& own = cameras_[camera];
  if (own.pictures.empty()) return {};
  const TakeLayout layout(take);
  if (Result<void> ok = make_matte_folder(layout, rig_camera.serial); !ok) return ok;
  // Numbers in names begin at 0 or at 1: counted they agree only where every picture has its contour.
  const int pictures = range_.first + (count - 1) * range_.step + 1;
  const bool to_the_end = !range_.end && range_.step == 1;
  if (own.of_video > 0 && (to_the_end ? own.of_video != pictures : own.of_video < pictures))
    return fail(ErrorCode::NotFound,
                text(given_.string(), ": camera '", rig_camera.serial, "' has ", own.of_video,
                     " contours, but its video has ", pictures,
                     " pictures; each needs one, an empty one where the subject is not there"));
  for (int frame = 0; frame < count; ++frame) {
    const int at = one_picture_[camera] ? 0 : range_.first + frame * range_.step;
    const auto contours = own.pictures.find(at);
    if (contours == own.pictures.end())
      return fail(ErrorCode::NotFound, text(given_.string(), ": camera '", rig_camera.serial,
                                            "' has contours, but none of its picture ", at,
                                            "; each needs one, an empty one where the subject is not there"));
    const PictureContours& picture = contours->second;
    if (picture.width != rig_camera.model.width || picture.height != rig_camera.model.height)
      return fail(ErrorCode::BadData,
                  text(given_.string(), ": the contours of picture ", at, " are of ", picture.width, "x",
                       picture.height, " pixels, but the pictures of camera '", rig_camera.serial, "' are ",
                       rig_camera.model.width, "x", rig_camera.model.height));
    if (Result<void> ok = save_png(matte_of(picture), layout.matte(rig_camera.serial, frame)); !ok) return ok;
  }
  return {};
}

}  // namespace floatstage::pipeline
