#include "pipeline/matte/consistent_take.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "core/text.h"
#include "matting/view_cut.h"
#include "pipeline/matte/fitting_plate.h"

namespace floatstage::pipeline {
namespace {

constexpr int kFewInstants = 8;  // below, a clip does not show what stands still
constexpr int kTrainingFrames = 16;
constexpr std::size_t kMostRemarks = 40;
constexpr double kMostOverexposed = 0.1;  // of an empty stage: lamps and windows have less

Result<Image> photograph(capture::TakeReader& take, int camera, int frame) {
  Result<Frame> photograph = take.frame(camera, frame);
  if (!photograph) return forward(photograph);
  if (photograph->empty()) return Image();
  return to_rgb(*photograph);
}

// Of one camera, spread over the take, of its working size; empty where there is no photograph.
Result<std::vector<Image>> training_pictures(capture::TakeReader& take, int camera,
                                             const Eigen::Vector2i& size) {
  const int count = take.frame_count(), training_frames = std::min(kTrainingFrames, count);
  std::vector<Image> pictures;
  for (int i = 0; i < training_frames; ++i) {
    Result<Image> picture =
        photograph(take, camera, static_cast<int>((2L * i + 1) * count / (2L * training_frames)));
    if (!picture) return forward(picture);
    pictures.push_back(picture->empty() ? Image() : matting::shrunk(*picture, size.x(), size.y()));
  }
  return pictures;
}

// What a person marked in one camera's frame; empty where nobody did.
Image said_of(const CameraEdits& edits, int frame, const CameraModel& model) {
  Image map(model.width, model.height, 1, 128);
  for (const MatteKeyframe& k : edits.keyframes)
    if (k.frame == frame) paint_strokes(k.strokes, 1, map);
  paint_masks(edits.masks, frame, 1, map);
  const bool marked = std::any_of(map.pixels.begin(), map.pixels.end(), [](int v) { return v != 128; });
  return marked ? map : Image();
}

class Maker {
 public:
  Maker(capture::TakeReader& take, const MatteEdits& edits, const ConsistentTakeOptions& options,
        ConsistentMatting matting, MatteStore* store)
      : take_(take), edits_(edits), options_(options), matting_(std::move(matting)), store_(store) {
    report_.cameras.resize(options.cameras.size());
  }

  Result<void> prepare() {
    const std::size_t cameras = take_.rig().cameras.size();
    if (Result<void> ok = look_at_plates(); !ok) return ok;
    if (take_.frame_count() < kFewInstants || std::find(shot_.begin(), shot_.end(), false) == shot_.end())
      return {};
    std::vector<Result<std::vector<Image>>> read(cameras, std::vector<Image>());
    {
      ProgressPart progress(options_.progress, "backdrops", cameras);
      parallel_for(cameras, options_.matting.threads, [&](std::size_t i) {
        if (is_cancelled(options_.progress)) return;
        const int camera = static_cast<int>(i);
        read[i] = training_pictures(take_, camera, matting_.working_size(camera));
        progress.advance();
      });
    }
    for (Result<std::vector<Image>>& pictures : read) {
      if (!pictures) return forward(pictures);
      seen_.push_back(std::move(*pictures));
    }
    if (is_cancelled(options_.progress)) return cancelled();
    if (Result<void> ok = learn_backdrops({}); !ok) return ok;
    // Whoever hardly moves was taken for backdrop where he stayed longest; so backdrops are learnt again from
    // what mattes leave of the pictures.
    for (const ConsistentMatting::Margin margin :
         {ConsistentMatting::Margin::Bridged, ConsistentMatting::Margin::Close})
      if (Result<void> ok = revise_backdrops(margin); !ok) return ok;
    seen_.clear();
    return {};
  }

  Result<void> make(int frame) {
    const bool any = std::any_of(options_.cameras.begin(), options_.cameras.end(),
                                 [&](const ConsistentTakeOptions::Camera& c) { return asked(c, frame); });
    if (!any) {
      matting_.forget();
      warm_ = false;
      return {};
    }
    Result<ConsistentMattes> made = mattes_of(frame);
    if (!made) return forward(made);
    report_.distrusted += !made->trusted;
    for (const std::string& r : made->remarks)
      if (!is_doubted(*made, frame, r)) report_.remarks.push_back(text("frame ", frame, ": ", r));
    for (std::size_t i = 0; i < options_.cameras.size(); ++i) {
      if (!asked(options_.cameras[i], frame)) continue;
      const auto camera = static_cast<std::size_t>(options_.cameras[i].index);
      ConsistentTakeReport::Camera& c = report_.cameras[i];
      if (made->mattes[camera].empty()) {
        ++c.gaps;
        continue;
      }
      const Result<bool> ok = store_->put(take_.rig().cameras[camera].serial, frame, made->mattes[camera]);
      if (!ok) return forward(ok);
      add(made->views[camera], c);
      doubt(*made, frame, static_cast<int>(camera));
    }
    return {};
  }

  Result<ConsistentMattes> mattes_of(int frame) {
    const std::vector<RigCamera>& cameras = take_.rig().cameras;
    std::vector<Result<Image>> read(cameras.size(), Image());
    std::vector<Image> pictures(cameras.size()), said(cameras.size());
    parallel_for(cameras.size(), options_.matting.threads, [&](std::size_t i) {
      read[i] = photograph(take_, static_cast<int>(i), frame);
      const auto found = edits_.cameras.find(cameras[i].serial);
      if (found != edits_.cameras.end()) said[i] = said_of(found->second, frame, cameras[i].model);
    });
    for (std::size_t i = 0; i < read.size(); ++i) {
      if (!read[i])
        return fail(read[i].error().code,
                    text("camera '", cameras[i].serial, "', frame ", frame, ": ", read[i].error().message));
      pictures[i] = std::move(*read[i]);
    }
    const auto go_on = [&] { return !is_cancelled(options_.progress); };
    Result<ConsistentMattes> made = matting_.matte(pictures, said, go_on);
    if (made && !made->trusted && warm_) {  // what the last instant left may be what is wrong
      matting_.forget();
      made = matting_.matte(pictures, said, go_on);
    }
    if (!made && made.error().code != ErrorCode::Cancelled)
      return fail(made.error().code, text("frame ", frame, ": ", made.error().message));
    warm_ = static_cast<bool>(made);
    return made;
  }

  ConsistentTakeReport finish() {
    for (ConsistentTakeReport::Camera& c : report_.cameras)
      for (double* sum : {&c.mean.subject, &c.mean.sure, &c.mean.border, &c.mean.missing, &c.mean.surplus})
        *sum /= std::max(1, c.made);
    if (const int walls = matting_.walls(); walls > 0)
      report_.remarks.insert(
          report_.remarks.begin(),
          text(
              "what is darker on ", walls, walls > 1 ? " walls" : " wall",
              " behind the subject is taken for shadow in all cameras, and is in no matte; if it is somebody "
              "who stands there in dark clothes, take him in with strokes or another --matte"));
    if (most_white_ > kMostOverexposed)
      report_.remarks.insert(
          report_.remarks.begin(),
          text(std::lround(100 * most_white_), " % of the empty stage is overexposed in camera '", whitest_,
               "'; what is as white before it, be it a face or a shirt, cannot be told from it and may lack; "
               "less light on the stage or a shorter exposure shows it"));
    if (report_.remarks.size() > kMostRemarks) {
      const std::size_t more = report_.remarks.size() - kMostRemarks;
      report_.remarks.resize(kMostRemarks);
      report_.remarks.push_back(text("and ", more, " more remarks like these"));
    }
    return std::move(report_);
  }

 private:
  // The empty stage, of cameras that somebody shot it with.
  Result<void> look_at_plates() {
    const std::size_t cameras = take_.rig().cameras.size();
    shot_.assign(cameras, false);
    std::vector<Result<matting::Plate>> plates(cameras, matting::Plate());
    parallel_for(cameras, options_.matting.threads, [&](std::size_t i) {
      if (is_cancelled(options_.progress)) return;
      plates[i] = fitting_plate(take_, static_cast<int>(i));
    });
    for (std::size_t i = 0; i < cameras; ++i) {
      if (!plates[i]) return forward(plates[i]);
      if (plates[i]->color.empty()) continue;
      if (const double white = matting::overexposed_share(plates[i]->color); white > most_white_) {
        most_white_ = white;
        whitest_ = take_.rig().cameras[i].serial;
      }
      if (Result<void> ok = matting_.learn_empty_stage(static_cast<int>(i), std::move(*plates[i])); !ok)
        return ok;
      shot_[i] = true;
    }
    return is_cancelled(options_.progress) ? cancelled() : Result<void>();
  }

  // `subjects[camera][instant]`: where somebody may be; empty: nothing is known of that.
  Result<void> learn_backdrops(const std::vector<std::vector<Image>>& subjects) {
    std::vector<Result<void>> learnt(seen_.size());
    parallel_for(seen_.size(), options_.matting.threads, [&](std::size_t i) {
      if (shot_[i]) return;
      std::vector<Image> there, near;
      for (std::size_t k = 0; k < seen_[i].size(); ++k) {
        if (seen_[i][k].empty() || (!subjects.empty() && subjects[i][k].empty())) continue;
        there.push_back(seen_[i][k]);
        if (!subjects.empty()) near.push_back(subjects[i][k]);
      }
      if (static_cast<int>(there.size()) >= kFewInstants)
        learnt[i] = matting_.learn_backdrop(static_cast<int>(i), there, near);
    });
    for (const Result<void>& ok : learnt)
      if (!ok) return ok;
    return {};
  }

  Result<void> revise_backdrops(ConsistentMatting::Margin margin) {
    const std::size_t instants = seen_[0].size();
    std::vector<std::vector<Image>> subjects(seen_.size(), std::vector<Image>(instants));
    ProgressPart progress(options_.progress, "backdrops without the subject", instants);
    matting_.forget();
    for (std::size_t k = 0; k < instants; ++k, progress.advance()) {
      std::vector<Image> now;
      for (const std::vector<Image>& pictures : seen_) now.push_back(pictures[k]);
      if (std::count_if(now.begin(), now.end(), [](const Image& p) { return !p.empty(); }) < 2) continue;
      Result<std::vector<Image>> near =
          matting_.surroundings(now, margin, [&] { return !is_cancelled(options_.progress); });
      if (!near) return forward(near);
      for (std::size_t i = 0; i < near->size(); ++i) subjects[i][k] = std::move((*near)[i]);
    }
    matting_.forget();
    return learn_backdrops(subjects);
  }

  static bool asked(const ConsistentTakeOptions::Camera& camera, int frame) {
    return camera.todo[static_cast<std::size_t>(frame)];
  }

  // Whether doubt() says it, of a camera whose matte is made here: no fault is said twice.
  bool is_doubted(const ConsistentMattes& made, int frame, const std::string& remark) const {
    for (const auto& [why, cameras] : made.wrong) {
      if (remark.find(why) == std::string::npos) continue;
      for (const ConsistentTakeOptions::Camera& c : options_.cameras)
        if (asked(c, frame) && !made.mattes[static_cast<std::size_t>(c.index)].empty() &&
            (cameras.empty() || std::find(cameras.begin(), cameras.end(), c.index) != cameras.end()))
          return true;
    }
    return false;
  }

  void doubt(const ConsistentMattes& made, int frame, int camera) {
    for (const auto& [why, cameras] : made.wrong)
      if (cameras.empty() || std::find(cameras.begin(), cameras.end(), camera) != cameras.end())
        store_->camera(take_.rig().cameras[static_cast<std::size_t>(camera)].serial)
            .doubts[why]
            .insert(frame);
  }

  static void add(const ConsistentView& view, ConsistentTakeReport::Camera& c) {
    ++c.made;
    c.mean.pictured = true;
    c.mean.subject += view.subject;
    c.mean.sure += view.sure;
    c.mean.border += view.border;
    c.mean.missing += view.missing;
    c.mean.surplus += view.surplus;
  }

  capture::TakeReader& take_;
  const MatteEdits& edits_;
  const ConsistentTakeOptions& options_;
  ConsistentMatting matting_;
  MatteStore* store_;  // none: nothing is written
  ConsistentTakeReport report_;
  bool warm_ = false;
  std::vector<bool> shot_;                // [camera]: its empty stage is known
  double most_white_ = 0;                 // share that is overexposed, of the empty stage of …
  std::string whitest_;                   // … this camera
  std::vector<std::vector<Image>> seen_;  // [camera][instant], while backdrops are learnt
};

}  // namespace

Result<ConsistentTakeReport> consistent_take(capture::TakeReader& take, const MatteEdits& edits,
                                             const ConsistentTakeOptions& options, MatteStore& store) {
  Result<ConsistentMatting> matting = ConsistentMatting::create(take.rig(), options.matting);
  if (!matting) return forward(matting);
  Maker maker(take, edits, options, std::move(*matting), &store);
  if (Result<void> ok = maker.prepare(); !ok) return forward(ok);
  ProgressPart progress(options.progress, "mattes", static_cast<std::size_t>(take.frame_count()));
  for (int frame = 0; frame < take.frame_count(); ++frame) {
    if (is_cancelled(options.progress)) return cancelled();
    if (Result<void> ok = maker.make(frame); !ok) return forward(ok);
    progress.advance();
  }
  return maker.finish();
}

Result<ConsistentMattes> consistent_instant(capture::TakeReader& take, int frame, int threads,
                                            Progress* progress) {
  const ConsistentTakeOptions options{.matting = {.threads = threads}, .progress = progress};
  Result<ConsistentMatting> matting = ConsistentMatting::create(take.rig(), options.matting);
  if (!matting) return forward(matting);
  const MatteEdits none;
  Maker maker(take, none, options, std::move(*matting), nullptr);
  if (Result<void> ok = maker.prepare(); !ok) return forward(ok);
  return maker.mattes_of(frame);
}

}  // namespace floatstage::pipeline
