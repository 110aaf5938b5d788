#include "pipeline/import/import.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/parallel.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/confined_job.h"
#include "pipeline/import/contour_files.h"
#include "pipeline/import/import_sound.h"
#include "pipeline/import/matte_files.h"
#include "pipeline/import/plate_files.h"
#include "pipeline/light_field.h"
#include "pipeline/progress.h"
#include "pipeline/recorded_take.h"
#include "pipeline/unfinished_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kLightField = "lightfield";
constexpr double kFolderFrameRate = 25;  // of numbered pictures, which state none

// The cameras that will be in the take, and where their pictures are.
struct Plan {
  calib::ForeignRig foreign;
  std::vector<CameraMedia> media;
  std::string format;
  fs::path pictures;
  std::vector<std::string> notes;
};

// "a, b, c and 17 more"
std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 3;
  std::string out;
  for (std::size_t i = 0; i < std::min(kShown, names.size()); ++i) out += (i ? ", " : "") + names[i];
  return names.size() > kShown ? text(out, " and ", names.size() - kShown, " more") : out;
}

// Keeps the cameras that the user named; all when none are named.
Result<calib::ForeignRig> chosen_cameras(const calib::ForeignRig& all,
                                         const std::vector<std::string>& serials) {
  if (serials.empty()) return all;
  calib::ForeignRig some;
  for (const std::string& serial : serials)
    if (camera_index(all.rig, serial) < 0) {
      std::vector<std::string> known;
      for (const RigCamera& c : all.rig.cameras) known.push_back(c.serial);
      return fail(ErrorCode::InvalidArgument,
                  text("the calibration has no camera '", serial, "'; it has ", listed(known)));
    }
  for (std::size_t i = 0; i < all.rig.cameras.size(); ++i) {
    const auto is_meant = [&](const std::string& serial) {
      return camera_index(all.rig, serial) == static_cast<int>(i);
    };
    if (std::none_of(serials.begin(), serials.end(), is_meant)) continue;
    some.rig.cameras.push_back(all.rig.cameras[i]);
    some.image_names.push_back(all.image_names[i]);
  }
  return some;
}

Result<Plan> make_plan(const ImportOptions& options) {
  const Result<const calib::RigFormat*> format =
      calib::rig_format(options.calibration.format, options.calibration.path);
  if (!format) return forward(format);
  const Result<calib::ForeignRig> calibration =
      (*format)->read(options.calibration.path, options.calibration.metres_per_unit);
  if (!calibration) return forward(calibration);
  std::error_code error;
  // Mattes alone make a take for hulls; their own pictures are then all that there is to see.
  const bool mattes_alone =
      options.pictures.empty() && !options.mattes.empty() && !fs::exists(calibration->pictures, error);
  const fs::path folder = mattes_alone               ? options.mattes
                          : options.pictures.empty() ? calibration->pictures
                                                     : options.pictures;
  Result<MediaSearch> search = find_media(folder, *calibration);
  if (!search) return forward(search);
  Result<calib::ForeignRig> chosen = chosen_cameras(*calibration, options.cameras);
  if (!chosen) return forward(chosen);

  Plan plan;
  plan.format = (*format)->name;
  plan.pictures = folder;
  std::vector<std::string> without;
  if (mattes_alone)
    plan.notes.push_back(text("there are no pictures in ", calibration->pictures.string(),
                              ": the mattes are shown in their place"));
  for (std::size_t i = 0; i < chosen->rig.cameras.size(); ++i) {
    const RigCamera& camera = chosen->rig.cameras[i];
    const CameraMedia& media =
        search->cameras[static_cast<std::size_t>(camera_index(calibration->rig, camera.serial))];
    if (media.empty()) {
      without.push_back(camera.serial);
      continue;
    }
    plan.foreign.rig.cameras.push_back(camera);
    plan.foreign.image_names.push_back(chosen->image_names[i]);
    plan.media.push_back(media);
  }
  if (plan.media.empty())
    return fail(
        ErrorCode::NotFound,
        text(folder.string(),
             ": holds no picture, video or folder of pictures named after a camera of the calibration (",
             listed(without), ")"));
  if (!without.empty())
    plan.notes.push_back(text(without.size(), " of ", chosen->rig.cameras.size(),
                              " calibrated cameras have no pictures and are left out: ", listed(without)));
  if (!search->unused.empty())
    plan.notes.push_back(
        text(search->unused.size(),
             " of the pictures have no calibration and are left out: ", listed(search->unused)));
  return plan;
}

// Whether every camera's pictures have their subject cut out in an alpha channel, by their first ones.
bool carry_mattes(const Plan& plan) {
  return std::all_of(plan.media.begin(), plan.media.end(), [](const CameraMedia& media) {
    if (media.stills.empty() || media.stills.front().extension() != ".png") return false;
    const Result<Image> picture = load_png(media.stills.front());
    if (!picture || picture->channels != 4) return false;
    for (std::size_t p = 3; p < picture->pixels.size(); p += 4)
      if (picture->pixels[p] < 255) return true;
    return false;
  });
}

Result<std::vector<PictureStream>> open_streams(const Plan& plan, const FrameRange& range, int threads) {
  std::vector<std::optional<Result<PictureStream>>> opened(plan.media.size());
  parallel_for(plan.media.size(), threads,
               [&](std::size_t i) { opened[i] = PictureStream::open(plan.media[i], range); });
  std::vector<PictureStream> streams;
  for (std::size_t i = 0; i < opened.size(); ++i) {
    if (!*opened[i])
      return fail(opened[i]->error().code,
                  text("camera '", plan.foreign.rig.cameras[i].serial, "': ", opened[i]->error().message));
    streams.push_back(std::move(**opened[i]));
  }
  return streams;
}

// A camera whose pictures were scaled, each axis by itself. Corners stay corners, so no half pixels appear.
CameraModel scaled(CameraModel m, int width, int height) {
  const double x = static_cast<double>(width) / m.width, y = static_cast<double>(height) / m.height;
  m.fx *= x, m.skew *= x, m.cx *= x;
  m.fy *= y, m.cy *= y;
  m.width = width, m.height = height;
  return m;
}

// The pictures know their size; where the calibration states another one, only the user knows why.
Result<Rig> sized_rig(const Rig& rig, const std::vector<PictureStream>& streams, OtherSize other,
                      std::vector<std::string>& notes) {
  Rig sized = rig;
  for (std::size_t i = 0; i < streams.size(); ++i) {
    CameraModel& m = sized.cameras[i].model;
    const int width = streams[i].width(), height = streams[i].height();
    if (m.width != 0 && (m.width != width || m.height != height)) {
      const std::string sizes = text("camera '", sized.cameras[i].serial, "': its pictures are ", width, "x",
                                     height, ", but it was calibrated for ", m.width, "x", m.height);
      if (other == OtherSize::Refuse)
        return fail(ErrorCode::BadData, text(sizes,
                                             "; give the pictures that it was calibrated with, say with "
                                             "--other-size whether they were scaled or cropped, "
                                             "or leave it out with --cameras"));
      if (other == OtherSize::Cropped && (width > m.width || height > m.height))
        return fail(ErrorCode::BadData,
                    text(sizes, ", which is less: they cannot have been cropped; try --other-size scaled"));
      if (other == OtherSize::Scaled) m = scaled(m, width, height);
      notes.push_back(text(sizes, other == OtherSize::Scaled
                                      ? ": its calibration was scaled with them"
                                      : ": taken for cropped at the right and the bottom"));
    }
    m.width = width;
    m.height = height;
  }
  if (Result<void> ok = check(sized); !ok) return forward(ok);
  return sized;
}

Result<double> frame_rate(const ImportOptions& options, const Plan& plan,
                          const std::vector<PictureStream>& streams, std::vector<std::string>& notes) {
  if (options.frame_rate) return *options.frame_rate;
  constexpr double kSameRate = 1e-3;  // relative: 29.97 and 30000/1001
  double rate = 0;
  std::size_t from = 0;
  bool folders = false;
  for (std::size_t i = 0; i < streams.size(); ++i) {
    folders = folders || plan.media[i].stills.size() > 1;
    const double own = streams[i].frame_rate();
    if (own <= 0) continue;
    if (rate > 0 && std::abs(own - rate) > kSameRate * rate)
      return fail(
          ErrorCode::InvalidArgument,
          text("camera '", plan.foreign.rig.cameras[i].serial, "' has ", own, " frames a second, but '",
               plan.foreign.rig.cameras[from].serial, "' has ", rate, "; say with --fps which is right"));
    if (rate == 0) from = i;
    if (rate == 0) rate = own;
  }
  if (rate == 0 && folders) {
    rate = kFolderFrameRate / options.frames.step;
    notes.push_back(
        text("folders of pictures state no frame rate: ", rate, " frames a second are assumed (--fps)"));
  }
  return rate;  // 0: one instant
}

FrameInfo info_of(std::size_t camera, int frame, double rate) {
  FrameInfo info;
  info.camera = static_cast<int>(camera);
  info.sequence = static_cast<std::uint64_t>(frame);
  info.exposure_start = {rate > 0 ? std::llround(frame * 1e9 / rate) : 0};
  return info;
}

// One camera from its first to its last picture; how many there were.
Result<int> copy_pictures(PictureStream& stream, std::size_t camera, double rate, const Progress* watch,
                          capture::TakeWriter& writer) {
  for (int frame = 0;; ++frame) {
    if (is_cancelled(watch)) return cancelled();
    Result<std::optional<Image>> picture = stream.next();
    if (!picture) return forward(picture);
    if (!*picture) return frame;
    if (Result<void> ok = writer.write(make_frame(info_of(camera, frame, rate), **picture)); !ok)
      return forward(ok);
  }
}

Result<std::unique_ptr<capture::TakeWriter>> begin_take(const ImportOptions& options, const Rig& rig,
                                                        double rate, const fs::path& folder) {
  capture::TakeWriterOptions take_options;
  take_options.codec = options.codec;
  take_options.frame_rate = rate;
  take_options.label = options.label;
  take_options.is_claimed = true;
  return capture::TakeWriter::create(folder, rig, take_options);
}

Result<void> end_take(const std::vector<VideoSound>& videos, capture::TakeWriter& writer,
                      const ImportOptions& options, const fs::path& folder, ImportReport& report) {
  const Result<int> sounds = import_sound(videos, folder, report.notes, options.progress);
  if (!sounds) return forward(sounds);
  report.sounds = *sounds;
  if (Result<void> ok = writer.finish(); !ok) return ok;
  return seal_take(folder, options.progress);
}

Result<void> write_pictures(const ImportOptions& options, const Rig& rig, std::vector<PictureStream>& streams,
                            const GivenMattes* mattes, double rate, const fs::path& folder,
                            ImportReport& report) {
  Result<std::unique_ptr<capture::TakeWriter>> writer = begin_take(options, rig, rate, folder);
  if (!writer) return forward(writer);

  std::vector<Result<int>> counts(streams.size(), Result<int>(0));
  std::vector<VideoSound> videos;
  ProgressPart progress(options.progress, "import", streams.size());
  parallel_for(streams.size(), options.threads, [&](std::size_t i) {
    counts[i] = copy_pictures(streams[i], i, rate, options.progress, **writer);
    if (counts[i] && mattes)
      if (Result<void> ok = mattes->save(i, rig.cameras[i], *counts[i], folder); !ok) counts[i] = forward(ok);
    progress.advance();
  });
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (!counts[i])
      return fail(counts[i].error().code,
                  text("camera '", rig.cameras[i].serial, "': ", counts[i].error().message));
    report.frames = std::max(report.frames, *counts[i]);
    if (!streams[i].video().empty() && options.sound)
      videos.push_back({rig.cameras[i].serial,
                        streams[i].video(),
                        {.first = streams[i].first_time(),
                         .last = streams[i].last_time(),
                         .take_first = info_of(i, 0, rate).exposure_start,
                         .take_last = info_of(i, *counts[i] - 1, rate).exposure_start}});
  }
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (*counts[i] == report.frames) continue;
    report.notes.push_back(text("camera '", rig.cameras[i].serial, "' has ", *counts[i], " of ",
                                report.frames, " frames: the rest are gaps"));
    for (int frame = *counts[i]; frame < report.frames; ++frame, ++report.gaps) {
      Frame gap;
      gap.info = info_of(i, frame, rate);
      gap.info.status = FrameStatus::Lost;
      if (Result<void> ok = (*writer)->write(gap); !ok) return ok;
    }
  }
  return end_take(videos, **writer, options, folder, report);
}

std::string milliseconds_of(double seconds) { return text(std::round(1e5 * seconds) / 100, " ms"); }

// The same of videos that were started by hand.
Result<void> write_synced(const ImportOptions& options, const Plan& plan, const Rig& rig,
                          const fs::path& folder, ImportReport& report) {
  const Result<SyncedVideos> synced = sync_videos(plan.media, report.serials, *options.sync,
                                                  options.frame_rate, options.threads, options.progress);
  if (!synced) return forward(synced);
  report.sync = synced->found;
  report.frames = static_cast<int>(synced->cameras.front().pictures.size());
  const bool claps = *options.sync == SyncSign::Clap;
  const std::string sign = claps ? "clap" : "flash", signs = claps ? "claps" : "flashes";
  for (const CameraSync& c : synced->found)
    if (c.serial != report.serials.front())
      report.notes.push_back(text("camera '", c.serial, "' began ", milliseconds_of(std::abs(c.seconds)),
                                  c.seconds < 0 ? " after '" : " before '", report.serials.front(), "', by ",
                                  c.events, " ", c.events == 1 ? sign : signs,
                                  c.events > 1 ? text(", which agree to ", milliseconds_of(c.spread)) : ""));
  report.notes.push_back(text("the take has the ", report.frames, " instants in which all cameras run, ",
                              synced->frame_rate, " a second",
                              options.frame_rate ? "" : " as the slowest one has (--fps)"));
  Result<std::vector<PictureStream>> streams = open_streams(plan, {}, options.threads);
  if (!streams) return forward(streams);
  Result<std::unique_ptr<capture::TakeWriter>> writer = begin_take(options, rig, synced->frame_rate, folder);
  if (!writer) return forward(writer);
  std::vector<Result<int>> gaps(streams->size(), Result<int>(0));
  ProgressPart progress(options.progress, "import", streams->size());
  parallel_for(streams->size(), options.threads, [&](std::size_t i) {
    gaps[i] = copy_synced((*streams)[i], synced->cameras[i], i, options.progress, **writer);
    progress.advance();
  });
  std::vector<VideoSound> videos;
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    const std::string& serial = rig.cameras[i].serial;
    if (!gaps[i]) return fail(gaps[i].error().code, text("camera '", serial, "': ", gaps[i].error().message));
    if (*gaps[i] > 0)
      report.notes.push_back(text("camera '", serial, "' has no picture at ", *gaps[i], " of ", report.frames,
                                  " instants: they are gaps"));
    report.gaps += *gaps[i];
    if (options.sound && synced->cameras[i].sound.first)
      videos.push_back({serial, plan.media[i].video, synced->cameras[i].sound});
  }
  return end_take(videos, **writer, options, folder, report);
}

Result<void> make_plane(const fs::path& folder, std::optional<double> distance, ImportReport& report) {
  const Result<std::unique_ptr<capture::TakeReader>> reader = capture::TakeReader::open(folder);
  if (!reader) return forward(reader);
  const Result<double> plane = give_plane(**reader, distance);
  if (!plane) return forward(plane);
  report.notes.push_back(text("the plane that the light field is drawn on stands ", *plane,
                              " m before its cameras",
                              distance ? "" : ", where neighbouring pictures agree best"));
  return {};
}

// What is known of the subject: mattes, contours, the pictures' own opacity, or nothing.
Result<std::unique_ptr<GivenMattes>> given_mattes(const ImportOptions& options, Plan& plan) {
  if (!options.contours.empty()) {
    Result<ContourFiles> found = ContourFiles::find(options.contours, plan.foreign, plan.media,
                                                    options.frames, options.contour_options);
    if (!found) return forward(found);
    return std::unique_ptr<GivenMattes>(new ContourFiles(*std::move(found)));
  }
  fs::path folder = options.mattes;
  if (folder.empty() && carry_mattes(plan)) {
    folder = plan.pictures;
    plan.notes.push_back("the alpha channel of the pictures is taken for their mattes");
  }
  if (folder.empty()) return std::unique_ptr<GivenMattes>();
  Result<MatteFiles> found = MatteFiles::find(folder, plan.foreign, options.frames);
  if (!found) return forward(found);
  return std::unique_ptr<GivenMattes>(new MatteFiles(*std::move(found)));
}

// Photographs of the empty stage, in a take that has its pictures.
Result<void> add_plates(const PlateFiles& plates, const ImportOptions& options, const Rig& rig,
                        const fs::path& folder, ImportReport& report) {
  std::vector<Result<void>> saved(rig.cameras.size());
  ProgressPart progress(options.progress, "plates", rig.cameras.size());
  parallel_for(rig.cameras.size(), options.threads, [&](std::size_t i) {
    saved[i] = plates.save(i, rig.cameras[i], folder);
    progress.advance();
  });
  for (std::size_t i = 0; i < saved.size(); ++i)
    if (!saved[i])
      return fail(saved[i].error().code,
                  text("camera '", rig.cameras[i].serial, "': ", saved[i].error().message));
  report.plates = static_cast<int>(rig.cameras.size() - plates.without().size());
  for (const std::string& serial : plates.without())
    report.notes.push_back(text("camera '", serial, "' has no plate"));
  return {};
}

// Sensors' pixels are square, and a calibration that had too little to tell both focal lengths from makes up
// others. Lenses and converters that squeeze pictures exist, so it is said and not refused.
void note_odd_pixels(const Rig& rig, std::vector<std::string>& notes) {
  constexpr double kOdd = 1.05;
  const RigCamera* oddest = nullptr;
  double most = kOdd;
  int odd = 0;
  for (const RigCamera& camera : rig.cameras) {
    const double shape = std::max(camera.model.fx / camera.model.fy, camera.model.fy / camera.model.fx);
    if (shape <= kOdd) continue;
    ++odd;
    if (shape >= most) most = shape, oddest = &camera;
  }
  if (oddest)
    notes.push_back(text(odd, " of ", rig.cameras.size(),
                         " cameras have pixels that are not square (camera '", oddest->serial, "': fx ",
                         oddest->model.fx, ", fy ", oddest->model.fy,
                         "); unless the pictures were squeezed, the calibration saw too little to tell "
                         "its focal lengths: give it a model with one"));
}

// What a take of these pictures needs at most: 24 bytes a pixel of the largest picture that is read at all,
// and of each camera what a decoder keeps of 4K video (16 pictures and what is made of them), or 16 pictures
// of 4 bytes of a calibration for more.
void confine_memory_to(const Plan& plan) {
  constexpr std::uint64_t kOwn = std::uint64_t{6} << 30, kCamera = std::uint64_t{1} << 30, kPicture = 64;
  std::uint64_t bytes = kOwn;
  for (const RigCamera& camera : plan.foreign.rig.cameras)
    bytes += std::max(kCamera, kPicture * static_cast<std::uint64_t>(std::max(camera.model.width, 0)) *
                                   static_cast<std::uint64_t>(std::max(camera.model.height, 0)));
  confine_memory(bytes);
}

/// Makes the take in `folder`, of foreign files, and its report.
Result<ImportReport> fill(ImportOptions options, const fs::path& folder) {
  Result<Plan> plan = make_plan(options);
  if (!plan) return forward(plan);
  confine_memory_to(*plan);
  if (options.label.empty()) options.label = plan->format;
  const Result<std::unique_ptr<GivenMattes>> mattes = given_mattes(options, *plan);
  if (!mattes) return forward(mattes);
  std::optional<PlateFiles> plates;
  if (!options.plates.empty()) {
    Result<PlateFiles> found = PlateFiles::find(options.plates, plan->foreign);
    if (!found) return forward(found);
    plates = *std::move(found);
  }
  Result<std::vector<PictureStream>> streams = open_streams(*plan, options.frames, options.threads);
  if (!streams) return forward(streams);
  ImportReport report;
  report.format = plan->format;
  report.notes = plan->notes;
  if (*mattes) {
    for (const std::string& serial : (*mattes)->without())
      report.notes.push_back(
          text("camera '", serial, "' has no matte: it does not carve, and is compared with only"));
    for (const std::string& note : (*mattes)->notes()) report.notes.push_back(note);
  }
  note_odd_pixels(plan->foreign.rig, report.notes);
  const Result<Rig> sized = sized_rig(plan->foreign.rig, *streams, options.other_size, report.notes);
  if (!sized) return forward(sized);
  const Result<WorldChange> change = world_change(*sized, options.world);
  if (!change) return forward(change);
  const Result<Rig> rig = in_world(*sized, *change);
  report.world = text(options.world.empty() ? "the world is taken as the calibration has it: "
                                            : "the world is as --up, --scale and --floor say: ",
                      describe_world(*rig));
  report.mattes = *mattes != nullptr;
  for (const RigCamera& c : rig->cameras) report.serials.push_back(c.serial);
  if (plates)
    if (Result<void> ok = add_plates(*plates, options, *rig, folder, report); !ok) return forward(ok);
  if (options.sync) {
    if (Result<void> ok = write_synced(options, *plan, *rig, folder, report); !ok) return forward(ok);
    return report;
  }
  const Result<double> rate = frame_rate(options, *plan, *streams, report.notes);
  if (!rate) return forward(rate);
  if (Result<void> ok = write_pictures(options, *rig, *streams, mattes->get(), *rate, folder, report); !ok)
    return forward(ok);
  return report;
}

}  // namespace

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CameraSync, serial, seconds, events, spread)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ImportReport, serials, frames, gaps, mattes, plates, sounds, sync, notes,
                                   world, format)

Result<ImportReport> import_take(const ImportOptions& options) {
  if (!options.mattes.empty() && !options.contours.empty())
    return fail(ErrorCode::InvalidArgument, "--mattes and --contours say the same of the subject; give one");
  const bool all_frames = options.frames.first == 0 && !options.frames.end && options.frames.step == 1;
  if (options.sync && !(all_frames && options.mattes.empty() && options.contours.empty()))
    return fail(ErrorCode::InvalidArgument,
                "--sync gives pictures other numbers than their videos have, so --frames, --mattes and "
                "--contours cannot be meant with it; leave them out, and trim the take (take trim)");
  Result<UnfinishedFolder> take = UnfinishedFolder::begin(options.out);
  if (!take) return forward(take);
  Result<ImportReport> report = run_confined_job<ImportReport>(
      {.what = options.calibration.path.string(), .writable = {take->folder()}}, options.progress,
      [&](Progress* progress) {
        ImportOptions confined = options;
        confined.progress = progress;
        return fill(std::move(confined), take->folder());
      });
  if (!report) return forward(report);
  if (report->format == kLightField)
    if (Result<void> ok = make_plane(take->folder(), options.plane, *report); !ok) return forward(ok);
  if (Result<void> ok = take->publish(); !ok) return forward(ok);
  return report;
}

}  // namespace floatstage::pipeline
