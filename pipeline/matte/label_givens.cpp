#include "pipeline/matte/label_givens.h"

#include <algorithm>
#include <charconv>
#include <functional>
#include <optional>

#include "core/file_presence.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/made_files.h"
#include "pipeline/matte/mask_of.h"
#include "pipeline/scene_loader.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr double kClick = 1.0 / 200;  // of the picture's longer side, as matte-image has it

std::optional<int> frame_named(const std::string& stem) {
  int frame = 0;
  const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), frame);
  if (error != std::errc() || end != stem.data() + stem.size() || frame < 0) return std::nullopt;
  return frame;
}

// Names in a folder, in order.
Result<std::vector<fs::path>> entries_of(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    entries.push_back(it->path());
  if (error) return fail(ErrorCode::Io, text("cannot list ", folder.string(), ": ", error.message()));
  std::sort(entries.begin(), entries.end());
  return entries;
}

class Painter {
 public:
  Painter(const capture::TakeReader& take, std::size_t labels, LabelGivens& givens)
      : take_(take), all_((std::uint64_t{1} << labels) - 1), givens_(givens) {}

  void mask(std::size_t label, int camera, int frame, const Image& mask) {
    LabelsAllowed& may = of(camera, frame);
    const auto bit = std::uint32_t{1} << label;
    for (std::size_t p = 0; p < may.size(); ++p) {
      if (mask.pixels[p] > 127)
        may[p] = bit;
      else if (const std::uint32_t left = (may[p] ? may[p] : static_cast<std::uint32_t>(all_)) & ~bit; left)
        may[p] = left;
    }
  }

  // InvalidArgument where the sum has nothing under it.
  Result<void> word(std::size_t label, int camera, const LabelWord& word) {
    const RigCamera& c = take_.rig().cameras[static_cast<std::size_t>(camera)];
    const auto where = [&] {
      const Eigen::Vector2d& at = word.stroke.points.front();
      return text("the ", word.stroke.points.size() > 1 ? "stroke" : "click", " of '", word.stroke.subject,
                  "' at ", at.x(), ",", at.y(), " in frame ", word.frame, " of camera '", word.serial, "'");
    };
    Image under(c.model.width, c.model.height, 1);
    paint_strokes({word.stroke}, 1, under);
    if (std::find(under.pixels.begin(), under.pixels.end(), 255) == under.pixels.end())
      return fail(ErrorCode::InvalidArgument,
                  text(where(), " is outside the picture of ", c.model.width, "x", c.model.height));
    const std::filesystem::path file = take_.layout().matte(word.serial, word.frame);
    if (!is_there(file))
      return fail(ErrorCode::NotFound,
                  text(where(), ": there is no matte; make that of this frame and camera first"));
    const Result<Image> sum = load_png(file);
    if (!sum) return forward(sum);
    if (sum->channels != 1 || sum->width != under.width || sum->height != under.height)
      return fail(ErrorCode::BadData, text(file.string(), " is not a grey picture of ", under.width, "x",
                                           under.height, " like camera '", word.serial, "'"));
    LabelsAllowed& may = of(camera, word.frame);
    bool any = false;
    for (std::size_t p = 0; p < may.size(); ++p)
      if (under.pixels[p] == 255 && sum->pixels[p] >= 128) may[p] = std::uint32_t{1} << label, any = true;
    if (any) return {};
    return fail(ErrorCode::InvalidArgument,
                text(where(), " is on nobody: the mattes have no subject there; click on the performer"));
  }

 private:
  LabelsAllowed& of(int camera, int frame) {
    LabelsAllowed& may = givens_[frame][camera];
    const CameraModel& m = take_.rig().cameras[static_cast<std::size_t>(camera)].model;
    if (may.empty()) may.assign(static_cast<std::size_t>(m.width) * static_cast<std::size_t>(m.height), 0);
    return may;
  }

  const capture::TakeReader& take_;
  const std::uint64_t all_;
  LabelGivens& givens_;
};

}  // namespace

const std::map<int, LabelsAllowed>* said_of(const LabelGivens& givens, int frame) {
  const auto said = givens.find(frame);
  return said == givens.end() ? nullptr : &said->second;
}

Result<void> read_label_masks(
    const capture::TakeReader& take, const LabelMasks& masks,
    const std::function<Result<void>(int camera, int frame, const Image& mask)>& each) {
  if (std::error_code error; !fs::is_directory(masks.folder, error))
    return fail(ErrorCode::NotFound, text(masks.folder.string(), " is no folder; masks of '", masks.label,
                                          "' lie in one as <serial>/<frame>.png"));
  int count = 0;
  const Result<std::vector<fs::path>> cameras = entries_of(masks.folder);
  if (!cameras) return forward(cameras);
  for (const fs::path& folder : *cameras) {
    if (std::error_code error; !fs::is_directory(folder, error)) continue;
    const std::string serial = folder.filename().string();
    const int camera = camera_index(take.rig(), serial);
    if (camera < 0)
      return fail(ErrorCode::InvalidArgument, text(folder.string(), ": the take has no camera '", serial,
                                                   "'; masks lie in <serial>/<frame>.png"));
    const CameraModel& model = take.rig().cameras[static_cast<std::size_t>(camera)].model;
    const Result<std::vector<fs::path>> files = entries_of(folder);
    if (!files) return forward(files);
    for (const fs::path& file : *files) {
      if (file.extension() != ".png") continue;
      const std::optional<int> frame = frame_named(file.stem().string());
      if (!frame || *frame >= take.frame_count())
        return fail(ErrorCode::InvalidArgument, text(file.string(), ": the take has no such frame; it has ",
                                                     take.frame_count(), ", counted from 0"));
      const Result<Image> picture = load_png(file);
      if (!picture) return forward(picture);
      if (picture->width != model.width || picture->height != model.height)
        return fail(ErrorCode::BadData,
                    text(file.string(), ": the mask is ", picture->width, "x", picture->height,
                         ", but the pictures of camera '", serial, "' are ", model.width, "x", model.height));
      if (Result<void> ok = each(camera, *frame, mask_of(*picture)); !ok) return ok;
      ++count;
    }
  }
  if (count > 0) return {};
  return fail(ErrorCode::NotFound,
              text(masks.folder.string(), " holds no mask; they are called <serial>/<frame>.png"));
}

Result<bool> is_others_label_matte(const TakeLayout& layout, const LabelRecord& record,
                                   const std::string& label, const std::string& serial, int frame) {
  const Result<std::optional<std::string>> hash = hash_of(layout.label_matte(serial, label, frame));
  if (!hash) return forward(hash);
  if (!*hash) return false;
  const auto files = record.files.find(label);
  if (files == record.files.end()) return true;
  const auto frames = files->second.find(serial);
  if (frames == files->second.end()) return true;
  const auto known = frames->second.find(frame);
  return known == frames->second.end() || known->second != **hash;
}

std::vector<LabelWord> label_words(const Rig& rig, const LabelRecord& record, const MatteEdits& edits) {
  std::vector<LabelWord> words;
  for (const LabelClick& click : record.clicks) {
    const int camera = camera_index(rig, click.serial);
    const CameraModel model =
        camera < 0 ? CameraModel() : rig.cameras[static_cast<std::size_t>(camera)].model;
    const double radius = std::max(1.0, kClick * std::max(model.width, model.height));
    words.push_back(
        {click.serial, click.frame, {MatteLabel::Foreground, radius, {{click.x, click.y}}, click.label}});
  }
  for (const auto& [serial, camera] : edits.cameras)
    for (const MatteKeyframe& keyframe : camera.keyframes)
      for (const MatteStroke& stroke : keyframe.strokes)
        if (!stroke.subject.empty()) words.push_back({serial, keyframe.frame, stroke});
  return words;
}

Result<LabelGivens> label_givens(const capture::TakeReader& take, const LabelRecord& record,
                                 const std::vector<LabelWord>& words, const fs::path& masks,
                                 std::vector<std::string>& hashes) {
  LabelGivens givens;
  Painter painter(take, record.labels.size(), givens);
  const TakeLayout& layout = take.layout();
  for (std::size_t l = 0; l < record.labels.size(); ++l) {
    const std::string& label = record.labels[l];
    bool any = false;
    const auto add = [&](int camera, int frame, const Image& mask, const fs::path& file) -> Result<void> {
      painter.mask(l, camera, frame, mask);
      const Result<std::optional<std::string>> hash = hash_of(file);
      if (!hash) return forward(hash);
      hashes.push_back(text(label, " ", camera, " ", frame, " ", hash->value_or("")));
      any = true;
      return {};
    };
    if (const fs::path folder = masks / label; is_there(folder)) {
      const auto each = [&](int camera, int frame, const Image& mask) {
        const std::string& serial = take.rig().cameras[static_cast<std::size_t>(camera)].serial;
        return add(camera, frame, mask, folder / serial / layout.matte(serial, frame).filename());
      };
      if (Result<void> ok = read_label_masks(take, {label, folder}, each); !ok) return forward(ok);
    }
    for (std::size_t c = 0; c < take.rig().cameras.size(); ++c) {
      const std::string& serial = take.rig().cameras[c].serial;
      for (const int frame : layout.frames_with_mattes(serial)) {
        const Result<bool> others = is_others_label_matte(layout, record, label, serial, frame);
        if (!others) return forward(others);
        if (!*others) continue;
        const fs::path file = layout.label_matte(serial, label, frame);
        const Result<Image> mask = load_png(file);
        if (!mask) return forward(mask);
        const CameraModel& model = take.rig().cameras[c].model;
        if (mask->channels != 1 || mask->width != model.width || mask->height != model.height)
          return fail(ErrorCode::BadData, text(file.string(), " is not a grey picture of ", model.width, "x",
                                               model.height, " like camera '", serial, "'; remove it"));
        if (Result<void> ok = add(static_cast<int>(c), frame, *mask, file); !ok) return forward(ok);
      }
    }
    any = any || std::any_of(words.begin(), words.end(),
                             [&](const LabelWord& word) { return word.stroke.subject == label; });
    if (!any)
      return fail(ErrorCode::InvalidArgument,
                  text("nothing says who '", label, "' is; give a mask or a click of each label"));
  }
  for (const LabelWord& word : words) {
    const std::string& label = word.stroke.subject;
    const int camera = camera_index(take.rig(), word.serial);
    if (camera < 0 || word.frame >= take.frame_count())
      return fail(ErrorCode::InvalidArgument,
                  text("a click of '", label, "' in frame ", word.frame, " of camera '", word.serial,
                       "', which the take does not have"));
    const auto l = std::find(record.labels.begin(), record.labels.end(), label) - record.labels.begin();
    if (Result<void> ok = painter.word(static_cast<std::size_t>(l), camera, word); !ok) return forward(ok);
  }
  return givens;
}

}  // namespace floatstage::pipeline
