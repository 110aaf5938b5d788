#include "pipeline/calibrate/session_observations.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "calib/detect.h"
#include "core/text.h"
#include "pipeline/calibrate/same_pictures.h"
#include "pipeline/import/media_files.h"
#include "pipeline/import/picture_stream.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {
namespace {

constexpr int kAlone = 1'000'000;  // frame numbers of pictures that one camera took alone begin here

struct Looked {
  std::vector<calib::Detection> detections;  // by picture
  int width = 0, height = 0;
  double frame_rate = 0;
};

bool is_picture(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const char* known : {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp"})
    if (extension == known) return true;
  return false;
}

// Pictures are decoded one after the other, some at a time, and looked at in parallel.
Result<Looked> look(const calib::TargetDesign& design, const CameraMedia& media, const FrameRange& range,
                    int every, const calib::DetectAllOptions& options) {
  const std::filesystem::path first = media.video.empty() ? media.stills.front() : media.video;
  Result<PictureStream> stream = PictureStream::open(media, range);
  if (!stream) return forward(stream);
  Looked out;
  out.width = stream->width();
  out.height = stream->height();
  out.frame_rate = stream->frame_rate();
  std::string key;
  if (!options.cache.empty() && !media.video.empty()) {
    const Result<std::string> content = calib::content_key(media.video);
    if (!content) return forward(content);
    key = *content;
  }
  constexpr std::size_t kAtOnce = 32;
  bool ended = false;
  for (int index = 0; !ended;) {
    std::vector<Image> images;
    std::vector<calib::PictureToDetect> batch;
    images.reserve(kAtOnce);
    while (images.size() < kAtOnce) {
      Result<std::optional<Image>> next = stream->next();
      if (!next) return forward(next);
      if (!*next) {
        ended = true;
        break;
      }
      const int here = index++;
      if (here % every != 0) continue;
      const std::size_t slot = images.size();
      images.push_back(std::move(**next));
      const std::string name = media.video.empty()
                                   ? media.stills[static_cast<std::size_t>(range.first + here)].string()
                                   : text(media.video.string(), " picture ", range.first + here);
      std::string picture_key;
      if (!key.empty()) picture_key = text(key, "-", range.first + here);
      if (!options.cache.empty() && media.video.empty()) {
        const Result<std::string> content = calib::content_key(name);
        if (content) picture_key = *content;
      }
      batch.push_back({name, picture_key, [&images, slot] { return Result<Image>(images[slot]); }});
    }
    for (calib::Detection& d : calib::detect_all(design, batch, options))
      out.detections.push_back(std::move(d));
  }
  return out;
}

void add_views(calib::Observations& o, int camera, const Looked& looked, int first, int every,
               double frame_rate) {
  for (std::size_t i = 0; i < looked.detections.size(); ++i) {
    if (looked.detections[i].points.empty()) continue;
    calib::TargetView view;
    view.camera = camera;
    view.frame = first + every * static_cast<int>(i);
    if (frame_rate > 0) view.time.ns = std::llround(1e9 * view.frame / frame_rate);
    view.points = looked.detections[i].points;
    o.views.push_back(std::move(view));
  }
}

std::string size_text(const Looked& l) { return text(l.width, "x", l.height); }

Result<void> collect_camera(const Session& s, const SessionCamera& camera,
                            const calib::DetectAllOptions& options, int& next_alone, SessionObservations& out,
                            std::size_t& synchronous) {
  calib::CalibrationCamera c;
  c.serial = camera.serial;
  c.lens = camera.lens;
  c.terms = camera.terms;
  const int index = static_cast<int>(out.observations.cameras.size());
  std::vector<calib::Detection> all;
  const auto take_size = [&](const Looked& l) -> Result<void> {
    if (c.width != 0 && (c.width != l.width || c.height != l.height))
      return fail(ErrorCode::BadData, text("camera '", c.serial, "': its pictures are ", size_text(l),
                                           " and ", c.width, "x", c.height, "; all must have one size"));
    c.width = l.width;
    c.height = l.height;
    return {};
  };
  synchronous = 0;
  CameraMedia media{camera.video, {}};
  if (Result<std::vector<std::filesystem::path>> stills = pictures_of(camera.images, camera.serial); !stills)
    return forward(stills);
  else
    media.stills = std::move(*stills);
  if (!media.empty()) {
    const Result<Looked> looked = look(*s.target, media, {s.first_frame, s.end_frame}, s.every, options);
    if (!looked) return fail(looked.error().code, text("camera '", c.serial, "': ", looked.error().message));
    if (Result<void> ok = take_size(*looked); !ok) return ok;
    synchronous = looked->detections.size();
    add_views(out.observations, index, *looked, s.first_frame, s.every,
              s.frame_rate > 0 ? s.frame_rate : looked->frame_rate);
    all = looked->detections;
  }
  if (media.empty() && camera.alone.empty()) {  // only of the scene: its size is asked for
    const Result<std::vector<std::filesystem::path>> scene = pictures_of(camera.scene, camera.serial);
    if (!scene) return forward(scene);
    const Result<PictureStream> stream = PictureStream::open({{}, {scene->front()}}, {});
    if (!stream)
      return fail(stream.error().code, text("camera '", camera.serial, "': ", stream.error().message));
    c.width = stream->width();
    c.height = stream->height();
    out.observations.cameras.push_back(std::move(c));
    return {};
  }
  const Result<std::vector<std::filesystem::path>> alone = pictures_of(camera.alone, camera.serial);
  if (!alone) return forward(alone);
  if (!alone->empty()) {
    const Result<Looked> looked = look(*s.target, {{}, *alone}, {}, 1, options);
    if (!looked) return fail(looked.error().code, text("camera '", c.serial, "': ", looked.error().message));
    if (Result<void> ok = take_size(*looked); !ok) return ok;
    add_views(out.observations, index, *looked, next_alone, 1, 0);
    next_alone += static_cast<int>(looked->detections.size());
    all.insert(all.end(), looked->detections.begin(), looked->detections.end());
  }
  for (const calib::Detection& d : all)
    if (d.failure == calib::DetectionFailure::Unreadable)
      return fail(ErrorCode::BadData, text("camera '", c.serial, "': ", d.reason));
  out.detection.push_back(text("camera '", c.serial, "': ", calib::summary(all)));
  out.observations.cameras.push_back(std::move(c));
  return {};
}

}  // namespace

Result<std::vector<std::filesystem::path>> pictures_of(const std::vector<std::filesystem::path>& given,
                                                       const std::string& serial) {
  std::vector<std::filesystem::path> out;
  for (const std::filesystem::path& p : given) {
    std::error_code error;
    if (!std::filesystem::is_directory(p, error)) {
      out.push_back(p);
      continue;
    }
    std::vector<std::filesystem::path> inside;
    for (const auto& entry : std::filesystem::directory_iterator(p, error))
      if (is_picture(entry.path())) inside.push_back(entry.path());
    if (error) return fail(ErrorCode::Io, text(p.string(), ": cannot be listed: ", error.message()));
    if (inside.empty())
      return fail(ErrorCode::NotFound, text("camera '", serial, "': there is no picture in ", p.string()));
    std::sort(inside.begin(), inside.end(), [](const auto& a, const auto& b) {
      return natural_less(a.filename().string(), b.filename().string());
    });
    out.insert(out.end(), inside.begin(), inside.end());
  }
  return out;
}

namespace {

Result<std::vector<std::string>> look_for_same_pictures(const Session& s) {
  std::vector<CameraFiles> all;
  for (const SessionCamera& camera : s.cameras) {
    CameraFiles files{camera.serial, {}};
    if (!camera.video.empty()) files.files.push_back(camera.video);
    for (const auto* given : {&camera.images, &camera.alone, &camera.scene}) {
      const Result<std::vector<std::filesystem::path>> found = pictures_of(*given, camera.serial);
      if (!found) return forward(found);
      files.files.insert(files.files.end(), found->begin(), found->end());
    }
    all.push_back(std::move(files));
  }
  return notice_same_pictures(all);
}

}  // namespace

Result<SessionObservations> collect(const Session& s, const std::filesystem::path& cache, int threads,
                                    Progress* watch) {
  const auto begin = std::chrono::steady_clock::now();
  SessionObservations out;
  if (!s.observations.empty()) {
    Result<calib::Observations> read = calib::load_observations(s.observations);
    if (!read) return forward(read);
    out.observations = std::move(*read);
  } else {
    if (Result<std::vector<std::string>> same = look_for_same_pictures(s); !same)
      return forward(same);
    else
      out.remarks = std::move(*same);
    if (s.target) out.observations.targets.push_back(calib::make_target(*s.target, "target", s.wand_sigma));
    ProgressPart progress(watch, "cameras", s.cameras.size());
    const calib::DetectAllOptions options{.threads = threads, .cache = cache};
    int next_alone = kAlone;
    std::size_t first_count = 0;
    std::string first_serial;
    for (const SessionCamera& camera : s.cameras) {
      std::size_t count = 0;
      if (camera.carried) continue;
      if (is_cancelled(watch)) return cancelled_unwritten();
      if (Result<void> ok = collect_camera(s, camera, options, next_alone, out, count); !ok)
        return forward(ok);
      progress.advance();
      if (count == 0) continue;
      if (first_serial.empty()) {
        first_serial = camera.serial;
        first_count = count;
      } else if (count != first_count) {
        return fail(ErrorCode::BadData, text("camera '", camera.serial, "' has ", count,
                                             " pictures, camera '", first_serial, "' has ", first_count,
                                             ": they are not of the same instants; repair the longer one, or "
                                             "give first_frame and end_frame"));
      }
    }
  }
  if (s.known) {
    const Result<Rig> rig = load_known(*s.known);
    if (!rig) return forward(rig);
    if (Result<void> ok = apply_known(*s.known, *rig, out.observations); !ok) return forward(ok);
  }
  if (s.floor) out.observations.gauge = calib::FloorBoard{0, s.floor->frame, s.floor->height};
  if (s.target)
    if (const std::optional<std::string> warning = calib::ambiguity(*s.target))
      out.remarks.push_back(*warning);
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

}  // namespace floatstage::pipeline
