#include "pipeline/matte/matte_clip.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>

#include <nlohmann/json.hpp>

#include "core/png.h"
#include "core/text.h"
#include "matting/labels/label_clip.h"
#include "pipeline/confined_job.h"
#include "pipeline/json_report.h"
#include "pipeline/matte/clip_pictures.h"
#include "pipeline/matte/doubt_picture.h"
#include "pipeline/matte/mask_of.h"
#include "pipeline/matte/matte_doubts.h"
#include "pipeline/unfinished_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr double kJump = 0.25;   // of the larger area: what no subject changes by from a frame to the next
constexpr double kBorder = 0.5;  // of the picture's border, as for takes: backdrops cover that much
// Of a label after the way to the clip's end and back: half of it was lost on the way there, and mattes are
// wanted with an IoU of 0.93.
constexpr double kLost = 2 * (1 - 0.93);
constexpr int kDoubtWidth = 960;  // px

std::string file_name(int frame) {
  char name[16];
  std::snprintf(name, sizeof name, "%06d.png", frame);
  return name;
}

Result<void> check(const MatteClipOptions& options) {
  if (options.guides.empty())
    return fail(ErrorCode::InvalidArgument,
                text(options.media.string(), " is no take; say who is to be cut out: --guide MASK.png"));
  std::map<std::string, int> seen;
  for (const ClipGuide& g : options.guides)
    if (g.label.empty() || g.label == "all" || g.label == "doubts" || g.label == "labels.json" ||
        g.label.find('/') != std::string::npos || g.label.front() == '.' || seen[g.label]++)
      return fail(
          ErrorCode::InvalidArgument,
          text("'", g.label, "' cannot be a label: each is a folder's name of its own, and not 'all'"));
  return {};
}

using Keys = std::map<int, matting::LabelMasks>;

Result<void> add_mask(const fs::path& file, int frame, int label, Keys& keys) {
  Result<Image> mask = load_png(file);
  if (!mask) return forward(mask);
  keys[frame][label] = mask_of(*mask);
  return {};
}

// Returns how many frames the guide has masks of.
Result<int> read_guide(const ClipGuide& guide, int label, const ClipPictures& clip, Keys& keys) {
  std::error_code error;
  if (!fs::is_directory(guide.masks, error)) {
    const int frame = std::max(0, clip.frame_of(guide.masks.stem().string()));
    if (Result<void> ok = add_mask(guide.masks, frame, label, keys); !ok) return forward(ok);
    return 1;
  }
  int count = 0;
  for (fs::directory_iterator it(guide.masks, error), end; !error && it != end; it.increment(error)) {
    if (it->path().extension() != ".png") continue;
    const int frame = clip.frame_of(it->path().stem().string());
    if (frame < 0)
      return fail(ErrorCode::InvalidArgument,
                  text(it->path().string(), ": the clip has no such frame; it has ", clip.frames()));
    if (Result<void> ok = add_mask(it->path(), frame, label, keys); !ok) return forward(ok);
    ++count;
  }
  if (error) return fail(ErrorCode::Io, text("cannot list ", guide.masks.string(), ": ", error.message()));
  if (count == 0) return fail(ErrorCode::NotFound, text(guide.masks.string(), " holds no PNG"));
  return count;
}

class Writer {
 public:
  Writer(const MatteClipOptions& options, fs::path folder, int frames, MatteClipReport& report)
      : options_(options),
        folder_(std::move(folder)),
        report_(report),
        shapes_(options.guides.size(), std::vector<MatteShape>(static_cast<std::size_t>(frames))) {}

  Result<void> begin() const {
    std::error_code error;
    for (const ClipGuide& g : options_.guides)
      if (!error) fs::create_directories(folder_ / g.label, error);
    if (options_.guides.size() > 1 && !error) fs::create_directories(folder_ / "all", error);
    if (error)
      return fail(ErrorCode::Io, text("cannot make folders in ", folder_.string(), ": ", error.message()));
    return {};
  }

  Result<void> write(int frame, const Image& picture, const Image& labels) {
    if (is_cancelled(options_.progress)) return cancelled_unwritten();
    const int count = static_cast<int>(options_.guides.size());
    Result<std::vector<Image>> mattes = matting::label_mattes(picture, labels, count);
    if (!mattes) return forward(mattes);
    report_.width = picture.width;
    report_.height = picture.height;
    Image sum(picture.width, picture.height, 1);
    for (std::size_t l = 0; l < mattes->size(); ++l) {
      const Image& matte = (*mattes)[l];
      for (std::size_t p = 0; p < sum.pixels.size(); ++p)
        sum.pixels[p] = static_cast<std::uint8_t>(std::min(255, sum.pixels[p] + matte.pixels[p]));
      shapes_[l][static_cast<std::size_t>(frame)] = shape_of(matte);
      if (Result<void> ok = save_png(matte, folder_ / options_.guides[l].label / file_name(frame)); !ok)
        return ok;
    }
    if (count > 1) return save_png(sum, folder_ / "all" / file_name(frame));
    return {};
  }

  void measure(const std::vector<matting::LabelReturn>& returns) {
    for (const matting::LabelReturn& r : returns)
      for (std::size_t l = 0; l < report_.labels.size(); ++l) {
        std::optional<ClipLabel::Lost>& lost = report_.labels[l].lost;
        if (!lost || r.lost[l + 1] > lost->share) lost = {r.key, r.end, r.lost[l + 1]};
      }
    for (std::size_t l = 0; l < shapes_.size(); ++l) {
      ClipLabel& label = report_.labels[l];
      const std::vector<MatteShape>& shapes = shapes_[l];
      for (std::size_t f = 0; f < shapes.size(); ++f) {
        label.subject += shapes[f].area / static_cast<double>(shapes.size());
        label.border = std::max(label.border, shapes[f].border);
        if (shapes[f].area == 0 && label.first_absent < 0) label.first_absent = static_cast<int>(f);
        if (f == 0) continue;
        const double larger = std::max(shapes[f].area, shapes[f - 1].area),
                     jump = larger > 0 ? std::abs(shapes[f].area - shapes[f - 1].area) / larger : 0;
        if (jump > label.jump) label.jump = jump, label.jumps_at = static_cast<int>(f);
      }
    }
  }

  // A sentence for each label that cannot be trusted, and its worst frame.
  Result<void> doubt(const ClipPictures& clip) {
    for (std::size_t l = 0; l < shapes_.size(); ++l) {
      const ClipLabel& label = report_.labels[l];
      int worst = -1;
      std::string why;
      if (label.first_absent >= 0) {
        worst = label.first_absent;
        why = text("nothing of it is left in frame ", worst);
      } else if (label.jump > kJump) {
        worst = label.jumps_at;
        why = text("its area changes by ", std::lround(100 * label.jump), " % at frame ", worst);
      } else if (label.border > kBorder) {
        const auto& shapes = shapes_[l];
        worst = static_cast<int>(
            std::max_element(shapes.begin(), shapes.end(),
                             [](const MatteShape& a, const MatteShape& b) { return a.border < b.border; }) -
            shapes.begin());
        why = text("it covers ", std::lround(100 * label.border), " % of the border of frame ", worst);
      } else if (label.lost && label.lost->share > kLost) {
        worst = label.lost->end;
        why = text("followed from frame ", label.lost->key, " to frame ", worst, " and back, it has lost ",
                   std::lround(100 * label.lost->share), " %");
      }
      if (worst < 0) continue;
      report_.doubts.push_back(
          text(label.name, ": ", why, "; give its mask there (see doubts/", label.name, ".png)"));
      if (Result<void> ok = show(clip, label.name, worst); !ok) return ok;
    }
    return {};
  }

 private:
  Result<void> show(const ClipPictures& clip, const std::string& name, int frame) const {
    Result<Image> picture = clip.picture(frame), matte = load_png(folder_ / name / file_name(frame));
    if (!picture) return forward(picture);
    if (!matte) return forward(matte);
    std::error_code error;
    fs::create_directories(folder_ / "doubts", error);
    return save_png(doubt_tile(*picture, make_matte({}, *matte), std::nullopt, kDoubtWidth),
                    folder_ / "doubts" / (name + ".png"));
  }

  const MatteClipOptions& options_;
  const fs::path folder_;
  MatteClipReport& report_;
  std::vector<std::vector<MatteShape>> shapes_;  // a label, a frame
};

Result<void> make(const MatteClipOptions& options, const fs::path& folder, MatteClipReport& report) {
  const fs::path scratch = folder / ".frames";
  Result<ClipPictures> clip = ClipPictures::open(options.media, scratch, options.progress);
  if (!clip) return forward(clip);
  report.frames = clip->frames();
  Keys keys;
  int labels = 0;
  for (const ClipGuide& guide : options.guides) {
    Result<int> count = read_guide(guide, ++labels, *clip, keys);
    if (!count) return forward(count);
    report.labels.push_back({.name = guide.label, .keyframes = *count});
  }
  Writer writer(options, folder, clip->frames(), report);
  if (Result<void> ok = writer.begin(); !ok) return ok;
  {
    ProgressPart part(options.progress, "mattes", static_cast<std::size_t>(clip->frames()));
    const matting::LabelClip frames{clip->frames(), [&](int f) -> Result<Image> {
                                      if (is_cancelled(options.progress)) return cancelled_unwritten();
                                      return clip->picture(f);
                                    }};
    const auto done = [&](int f, const Image& picture, const Image& found) {
      Result<void> ok = writer.write(f, picture, found);
      part.advance();
      return ok;
    };
    const auto returns = matting::follow_labels(frames, keys, labels, done);
    if (!returns) return forward(returns);
    writer.measure(*returns);
  }
  if (Result<void> ok = writer.doubt(*clip); !ok) return ok;
  std::error_code error;
  fs::remove_all(scratch, error);
  nlohmann::json names = nlohmann::json::array();
  for (const ClipGuide& g : options.guides) names.push_back(g.label);
  return save_json({{"labels", names}, {"frames", report.frames}}, folder / "labels.json");
}

}  // namespace

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ClipLabel::Lost, key, end, share)

// From the child that made the mattes to this process.
void to_json(nlohmann::json& json, const ClipLabel& label) {
  json = {label.name,     label.keyframes,    label.subject, label.jump,
          label.jumps_at, label.first_absent, label.border,  nullptr};
  if (label.lost) json.back() = *label.lost;
}

void from_json(const nlohmann::json& json, ClipLabel& label) {
  int at = 0;
  const auto next = [&](auto& value) { json.at(static_cast<std::size_t>(at++)).get_to(value); };
  next(label.name), next(label.keyframes), next(label.subject), next(label.jump), next(label.jumps_at);
  next(label.first_absent), next(label.border);
  if (const nlohmann::json& lost = json.at(static_cast<std::size_t>(at)); !lost.is_null())
    label.lost = lost.get<ClipLabel::Lost>();
}

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(MatteClipReport, frames, width, height, labels, doubts)

Result<MatteClipReport> matte_clip(const MatteClipOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  if (Result<void> ok = check(options); !ok) return forward(ok);
  Result<UnfinishedFolder> folder = UnfinishedFolder::begin(options.out);
  if (!folder) return forward(folder);
  Result<MatteClipReport> report =
      run_confined_job<MatteClipReport>({.what = options.media.string(), .writable = {folder->folder()}},
                                        options.progress, [&](Progress* progress) -> Result<MatteClipReport> {
                                          MatteClipOptions confined = options;
                                          confined.progress = progress;
                                          MatteClipReport made;
                                          if (Result<void> ok = make(confined, folder->folder(), made); !ok)
                                            return forward(ok);
                                          return made;
                                        });
  if (!report) return report;
  if (Result<void> ok = folder->publish(); !ok) return forward(ok);
  report->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace floatstage::pipeline
