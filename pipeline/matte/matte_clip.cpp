#include "pipeline/matte/matte_clip.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/file_presence.h"
#include "core/matte_edits.h"
#include "core/png.h"
#include "core/take_layout.h"
#include "core/text.h"
#include "matting/doubt_picture.h"
#include "matting/labels/label_clip.h"
#include "pipeline/confined_job.h"
#include "pipeline/json_report.h"
#include "pipeline/matte/clip_pictures.h"
#include "pipeline/matte/mask_of.h"
#include "pipeline/matte/matte_doubts.h"
#include "pipeline/unfinished_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using matting::LabelStroke;

constexpr double kClick = 1.0 / 200;  // of the picture's longer side, as in takes
constexpr double kJump = 0.25;   // of the larger area: what no subject changes by from a frame to the next
constexpr double kBorder = 0.5;  // of the picture's border, as for takes: backdrops cover that much
// Of a label after the way to the clip's end and back: half of it was lost on the way there, and mattes are
// wanted with an IoU of 0.93.
constexpr double kLost = 2 * (1 - 0.93);
constexpr double kJumped = 0.5;   // of a label, not found again from a frame to the next: the clip jumps
constexpr int kDoubtWidth = 960;  // px

std::string file_name(int frame) {
  char name[16];
  std::snprintf(name, sizeof name, "%06d.png", frame);
  return name;
}

// What was said of a clip beside masks.
struct Said {
  std::vector<std::string> labels;                  // those of guides first
  std::map<int, std::vector<LabelStroke>> strokes;  // by frame; a click's radius is 0 until pictures are seen
  std::vector<MatteMask> garbage;
};

bool is_label(const std::string& name) {
  return !name.empty() && name != "all" && name != "doubts" && name != "labels.json" &&
         name.find('/') == std::string::npos && name.front() != '.';
}

Result<void> check(const MatteClipOptions& options) {
  if (options.guides.empty() && options.clicks.empty() && options.edits.empty())
    return fail(ErrorCode::InvalidArgument,
                text(options.media.string(), " is no take; say who is to be cut out: --guide MASK.png"));
  std::map<std::string, int> seen;
  for (const ClipGuide& g : options.guides)
    if (!is_label(g.label) || seen[g.label]++)
      return fail(
          ErrorCode::InvalidArgument,
          text("'", g.label, "' cannot be a label: each is a folder's name of its own, and not 'all'"));
  return {};
}

// The edits of the one camera that a clip has.
Result<CameraEdits> read_edits(const fs::path& file) {
  if (file.empty()) return CameraEdits();
  if (!is_there(file)) return fail(ErrorCode::NotFound, text(file.string(), " is not there"));
  Result<MatteEdits> edits = load_matte_edits(file);
  if (!edits) return forward(edits);
  std::erase_if(edits->cameras, [](const auto& c) { return c.second == CameraEdits(); });
  if (edits->cameras.size() > 1)
    return fail(ErrorCode::InvalidArgument, text(file.string(), " is about ", edits->cameras.size(),
                                                 " cameras; a clip has one, so its file must be about one"));
  CameraEdits camera = edits->cameras.empty() ? CameraEdits() : edits->cameras.begin()->second;
  for (const MatteMask& mask : camera.masks)
    if (mask.label == MatteLabel::Foreground)
      return fail(
          ErrorCode::InvalidArgument,
          text(file.string(), ": a hold-out mask says of nobody whose it is, and a clip's labels are ",
               "cut one from another; draw a stroke in its place"));
  return camera;
}

Result<Said> read_said(const MatteClipOptions& options) {
  Result<CameraEdits> edits = read_edits(options.edits);
  if (!edits) return forward(edits);
  Said said;
  for (const ClipGuide& g : options.guides) said.labels.push_back(g.label);
  std::set<std::string> others;
  for (const ClipClick& c : options.clicks) others.insert(c.label);
  for (const MatteKeyframe& k : edits->keyframes)
    for (const MatteStroke& s : k.strokes)
      if (!s.subject.empty()) others.insert(s.subject);
  for (const std::string& label : others) {
    if (!is_label(label) || !is_usable_label(label))
      return fail(ErrorCode::InvalidArgument, text("'", label, "' cannot be a label of a clip"));
    if (std::find(said.labels.begin(), said.labels.end(), label) == said.labels.end())
      said.labels.push_back(label);
  }
  if (said.labels.empty()) said.labels.push_back("subject");
  const auto index = [&](const std::string& label) {
    return static_cast<int>(std::find(said.labels.begin(), said.labels.end(), label) - said.labels.begin()) +
           1;
  };
  for (const ClipClick& c : options.clicks)
    said.strokes[c.frame].push_back({index(c.label), {MatteLabel::Foreground, 0, {{c.x, c.y}}, c.label}});
  for (const MatteKeyframe& k : edits->keyframes)
    for (const MatteStroke& s : k.strokes)
      said.strokes[k.frame].push_back({s.subject.empty() ? 0 : index(s.subject), s});
  said.garbage = std::move(edits->masks);
  return said;
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
  Writer(const MatteClipOptions& options, const Said& said, fs::path folder, int frames,
         MatteClipReport& report)
      : options_(options),
        said_(said),
        folder_(std::move(folder)),
        report_(report),
        shapes_(said.labels.size(), std::vector<MatteShape>(static_cast<std::size_t>(frames))) {}

  Result<void> begin() const {
    std::error_code error;
    for (const std::string& label : said_.labels)
      if (!error) fs::create_directories(folder_ / label, error);
    if (said_.labels.size() > 1 && !error) fs::create_directories(folder_ / "all", error);
    if (error)
      return fail(ErrorCode::Io, text("cannot make folders in ", folder_.string(), ": ", error.message()));
    return {};
  }

  Result<void> write(int frame, const Image& picture, const Image& labels) {
    if (is_cancelled(options_.progress)) return cancelled_unwritten();
    const int count = static_cast<int>(said_.labels.size());
    Result<std::vector<Image>> mattes = matting::label_mattes(picture, labels, count);
    if (!mattes) return forward(mattes);
    Image garbage(picture.width, picture.height, 1, 128);
    paint_masks(said_.garbage, frame, 1, garbage);
    Image marked(picture.width, picture.height, 1, 128);  // by strokes: as the labels are, to the pixel
    if (const auto strokes = said_.strokes.find(frame); strokes != said_.strokes.end())
      for (const LabelStroke& s : strokes->second) paint_strokes({s.stroke}, 1, marked);
    for (std::size_t l = 0; l < mattes->size(); ++l)
      for (std::size_t p = 0; p < garbage.pixels.size(); ++p) {
        std::uint8_t& a = (*mattes)[l].pixels[p];
        if (marked.pixels[p] != 128) a = labels.pixels[p] == l + 1 ? 255 : 0;
        if (garbage.pixels[p] == 0) a = 0;
      }
    report_.width = picture.width;
    report_.height = picture.height;
    Image sum(picture.width, picture.height, 1);
    for (std::size_t l = 0; l < mattes->size(); ++l) {
      const Image& matte = (*mattes)[l];
      for (std::size_t p = 0; p < sum.pixels.size(); ++p)
        sum.pixels[p] = static_cast<std::uint8_t>(std::min(255, sum.pixels[p] + matte.pixels[p]));
      shapes_[l][static_cast<std::size_t>(frame)] = shape_of(matte);
      if (Result<void> ok = save_png(matte, folder_ / said_.labels[l] / file_name(frame)); !ok) return ok;
    }
    if (count > 1) return save_png(sum, folder_ / "all" / file_name(frame));
    return {};
  }

  void measure(const std::vector<matting::LabelReturn>& returns) {
    for (const matting::LabelReturn& r : returns)
      for (std::size_t l = 0; l < report_.labels.size(); ++l) {
        std::optional<ClipLabel::Lost>& lost = report_.labels[l].lost;
        if (!lost || r.lost[l + 1] > lost->share)
          lost = {r.key, r.end, r.lost[l + 1], r.jumps[l + 1].share, r.jumps[l + 1].frame};
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
        if (label.lost->jump > kJumped) {
          worst = label.lost->jumps_at;
          why += text("; the clip jumps at frame ", worst, ", where ", std::lround(100 * label.lost->jump),
                      " % of it is not found again");
        }
      }
      if (worst < 0) continue;
      report_.doubts.push_back(
          text(label.name, ": ", why, "; give its mask or a stroke there (see doubts/", label.name, ".png)"));
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
    return save_png(matting::doubt_tile(*picture, make_matte({}, *matte), std::nullopt, kDoubtWidth),
                    folder_ / "doubts" / (name + ".png"));
  }

  const MatteClipOptions& options_;
  const Said& said_;
  const fs::path folder_;
  MatteClipReport& report_;
  std::vector<std::vector<MatteShape>> shapes_;  // a label, a frame
};

// Strokes in the sizes of the pictures. InvalidArgument for what fits no frame.
Result<void> measure(const ClipPictures& clip, std::map<int, std::vector<LabelStroke>>& strokes) {
  for (auto& [frame, said] : strokes) {
    if (frame >= clip.frames())
      return fail(ErrorCode::InvalidArgument,
                  text("a stroke in frame ", frame, ": the clip has no such frame; it has ", clip.frames(),
                       ", counted from 0"));
    const Result<Image> picture = clip.picture(frame);
    if (!picture) return forward(picture);
    for (LabelStroke& s : said)
      if (s.stroke.radius == 0)
        s.stroke.radius = std::max(1.0, kClick * std::max(picture->width, picture->height));
  }
  return {};
}

std::string name_of(const Said& said, const LabelStroke& s) {
  const Eigen::Vector2d& at = s.stroke.points.front();
  const char* what = s.stroke.points.size() > 1 ? "stroke" : "click";
  const std::string whose = s.stroke.label == MatteLabel::Background ? " of the background"
                            : s.label == 0
                                ? " of the subject"
                                : text(" of '", said.labels[static_cast<std::size_t>(s.label - 1)], "'");
  return text("the ", what, whose, " at ", at.x(), ",", at.y());
}

// What became of strokes: those outside are refused, those that changed nothing named; and a label that
// nothing but what is marked was found of.
Result<void> answer(const Said& said, const matting::LabelsFollowed& followed,
                    const std::vector<int>& keyframes, MatteClipReport& report) {
  std::map<int, std::pair<int, long>>
      begun;  // of labels without masks: the first frame, and what turned there
  for (const auto& [frame, heard] : followed.heard) {
    const std::vector<LabelStroke>& strokes = said.strokes.at(frame);
    for (std::size_t i = 0; i < strokes.size(); ++i) {
      const LabelStroke& s = strokes[i];
      if (heard.effects[i] == matting::StrokeEffect::Outside)
        return fail(ErrorCode::InvalidArgument,
                    text(name_of(said, s), " in frame ", frame, " is outside the picture of ", report.width,
                         "x", report.height));
      if (heard.effects[i] == matting::StrokeEffect::Already)
        report.idle.push_back(text("frame ", frame, ": ", name_of(said, s),
                                   " changes nothing: all that it marks is so already"));
      if (s.label > 0 && keyframes[static_cast<std::size_t>(s.label - 1)] == 0) {
        const auto [it, first] = begun.try_emplace(s.label, frame, 0L);
        if (it->second.first == frame) it->second.second += heard.turned[i];
      }
    }
  }
  for (const auto& [label, from] : begun)
    if (from.second == 0)
      report.doubts.push_back(
          text(said.labels[static_cast<std::size_t>(label - 1)], ": in frame ", from.first,
               " nothing hangs together with what is marked of it; give a mask, or a stroke along it"));
  return {};
}

Result<void> make(const MatteClipOptions& options, Said said, const fs::path& folder,
                  MatteClipReport& report) {
  const fs::path scratch = folder / ".frames";
  Result<ClipPictures> clip = ClipPictures::open(options.media, scratch, options.progress);
  if (!clip) return forward(clip);
  report.frames = clip->frames();
  Keys keys;
  std::vector<int> keyframes(said.labels.size(), 0);
  for (std::size_t g = 0; g < options.guides.size(); ++g) {
    const Result<int> count = read_guide(options.guides[g], static_cast<int>(g) + 1, *clip, keys);
    if (!count) return forward(count);
    keyframes[g] = *count;
  }
  if (Result<void> ok = measure(*clip, said.strokes); !ok) return ok;
  for (std::size_t l = 0; l < said.labels.size(); ++l) {
    ClipLabel& label = report.labels.emplace_back();
    label.name = said.labels[l], label.keyframes = keyframes[l];
    for (const auto& [frame, strokes] : said.strokes)
      label.strokes +=
          static_cast<int>(std::count_if(strokes.begin(), strokes.end(), [&](const LabelStroke& s) {
            return s.label == static_cast<int>(l) + 1;
          }));
  }
  Writer writer(options, said, folder, clip->frames(), report);
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
    const Result<matting::LabelsFollowed> followed =
        matting::follow_labels(frames, keys, said.strokes, static_cast<int>(said.labels.size()), done);
    if (!followed) return forward(followed);
    writer.measure(followed->returns);
    if (Result<void> ok = answer(said, *followed, keyframes, report); !ok) return ok;
  }
  if (Result<void> ok = writer.doubt(*clip); !ok) return ok;
  std::error_code error;
  fs::remove_all(scratch, error);
  return save_json({{"labels", said.labels}, {"frames", report.frames}}, folder / "labels.json");
}

}  // namespace

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ClipLabel::Lost, key, end, share, jump, jumps_at)

// From the child that made the mattes to this process.
void to_json(nlohmann::json& j, const ClipLabel& label) {
  j = {label.name,     label.keyframes,    label.strokes, label.subject, label.jump,
       label.jumps_at, label.first_absent, label.border,  nullptr};
  if (label.lost) j.back() = *label.lost;
}

void from_json(const nlohmann::json& j, ClipLabel& label) {
  int at = 0;
  const auto next = [&](auto& value) { j.at(static_cast<std::size_t>(at++)).get_to(value); };
  next(label.name), next(label.keyframes), next(label.strokes), next(label.subject), next(label.jump);
  next(label.jumps_at), next(label.first_absent), next(label.border);
  if (const nlohmann::json& lost = j.at(static_cast<std::size_t>(at)); !lost.is_null())
    label.lost = lost.get<ClipLabel::Lost>();
}

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(MatteClipReport, frames, width, height, labels, doubts, idle)

Result<MatteClipReport> matte_clip(const MatteClipOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  if (Result<void> ok = check(options); !ok) return forward(ok);
  const Result<Said> said = read_said(options);
  if (!said) return forward(said);
  Result<UnfinishedFolder> folder = UnfinishedFolder::begin(options.out);
  if (!folder) return forward(folder);
  Result<MatteClipReport> report = run_confined_job<MatteClipReport>(
      {.what = options.media.string(), .writable = {folder->folder()}}, options.progress,
      [&](Progress* progress) -> Result<MatteClipReport> {
        MatteClipOptions confined = options;
        confined.progress = progress;
        MatteClipReport made;
        if (Result<void> ok = make(confined, *said, folder->folder(), made); !ok) return forward(ok);
        return made;
      });
  if (!report) return report;
  if (Result<void> ok = folder->publish(); !ok) return forward(ok);
  report->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace floatstage::pipeline
