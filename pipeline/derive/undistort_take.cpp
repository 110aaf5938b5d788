#include "pipeline/derive/undistort_take.h"

#include <algorithm>
#include <cmath>

#include "capture/added_file.h"
#include "capture/derivation.h"
#include "capture/sound/time_code.h"
#include "capture/time_offsets.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/parallel.h"
#include "core/png.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "pipeline/derive/carried_files.h"
#include "pipeline/occluders.h"
#include "pipeline/recorded_take.h"
#include "pipeline/take_added.h"
#include "pipeline/undistort.h"
#include "pipeline/unfinished_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

bool holds(const PixelBox& box, const Eigen::Vector2d& p) {
  return p.x() >= box.x && p.y() >= box.y && p.x() < box.x + box.width && p.y() < box.y + box.height;
}

// The smallest box around the straight pixels that show something of `box`.
PixelBox around(const Retaking& straighten, const PixelBox& box) {
  int left = straighten.width(), top = straighten.height(), right = 0, bottom = 0;
  for (int y = 0; y < straighten.height(); ++y)
    for (int x = 0; x < straighten.width(); ++x)
      if (const auto p = straighten.source(x, y); p && holds(box, *p)) {
        left = std::min(left, x), right = std::max(right, x + 1);
        top = std::min(top, y), bottom = std::max(bottom, y + 1);
      }
  return right > left ? PixelBox{left, top, right - left, bottom - top} : PixelBox{};
}

// What no lens has seen of the straight pictures: bars where the photographs reach nothing, overlays where
// they had some.
AddedContent added_to(const Retaking& straighten, const CameraModel& from, const AddedContent& before) {
  const PixelBox photographed = inside(before, from.width, from.height);
  Image seen(straighten.width(), straighten.height(), 1);
  for (int y = 0; y < seen.height; ++y)
    for (int x = 0; x < seen.width; ++x)
      if (const auto p = straighten.source(x, y); p && holds(photographed, *p)) *seen.at(x, y) = 1;
  const PixelBox box = largest_box(seen);
  AddedContent after;
  if (box.empty()) return {.left = seen.width};
  after.left = box.x, after.right = seen.width - box.x - box.width;
  after.top = box.y, after.bottom = seen.height - box.y - box.height;
  for (const PixelBox& overlay : before.overlays)
    if (const PixelBox to = around(straighten, overlay); !to.empty()) after.overlays.push_back(to);
  return after;
}

// The share of a photograph that a straight camera shows.
double share_kept(const CameraModel& from, const CameraModel& to) {
  constexpr int kEvery = 4;  // px
  int kept = 0, all = 0;
  for (int y = kEvery / 2; y < from.height; y += kEvery)
    for (int x = kEvery / 2; x < from.width; x += kEvery, ++all) {
      const auto ray = unproject(from, {x + 0.5, y + 0.5});
      const auto p = ray ? project(to, *ray) : std::nullopt;
      kept += p && inside(to, *p) ? 1 : 0;
    }
  return all > 0 ? static_cast<double>(kept) / all : 1;
}

class Straightening {
 public:
  Straightening(capture::TakeReader& from, const UndistortOptions& options, const fs::path& folder)
      : from_(from), options_(options), to_(folder), straight_(from.rig()) {
    for (RigCamera& c : straight_.cameras) c.model = straight(c.model);
    report_.frames = from.frame_count();
    report_.cameras.resize(straight_.cameras.size());
  }

  Result<UndistortReport> run(capture::TakeCodec codec, std::vector<std::string> notes) {
    report_.notes = std::move(notes);
    const bool settled = is_there(capture::added_file(from_.layout()));
    Result<capture::AddedFile> added = capture::load_added(from_.layout());
    if (!added) return forward(added);
    before_ = settled ? *std::move(added) : search_added(from_, options_.threads);
    hides_itself_ = settled;
    capture::TakeWriterOptions take;
    take.codec = codec;
    take.frame_rate = from_.manifest().frame_rate;
    take.label = options_.label.empty() ? from_.manifest().label : options_.label;
    take.created = from_.manifest().created;
    take.is_claimed = true;
    Result<std::unique_ptr<capture::TakeWriter>> writer =
        capture::TakeWriter::create(to_.folder(), straight_, take);
    if (!writer) return forward(writer);
    std::vector<Result<void>> done(straight_.cameras.size());
    std::vector<AddedContent> after(done.size());
    {
      ProgressPart part(options_.progress, "undistort",
                        done.size() * static_cast<std::size_t>(from_.frame_count()));
      parallel_for(done.size(), options_.threads,
                   [&](std::size_t c) { done[c] = camera(c, **writer, after[c], part); });
    }
    for (const Result<void>& of : done)
      if (!of) return forward(of);
    if (Result<void> ok = carry(); !ok) return forward(ok);
    if (Result<void> ok = hide(after); !ok) return forward(ok);
    if (Result<void> ok = (*writer)->finish(); !ok) return forward(ok);
    if (Result<void> ok = seal_take(to_.folder(), options_.progress); !ok) return forward(ok);
    if (Result<void> ok =
            capture::save_derivation({from_.layout().folder().string(), "undistort"}, to_.folder());
        !ok)
      return forward(ok);
    return report_;
  }

 private:
  Result<void> camera(std::size_t c, capture::TakeWriter& writer, AddedContent& after, ProgressPart& part) {
    const RigCamera &from = from_.rig().cameras[c], &to = straight_.cameras[c];
    StraightenedCamera& outcome = report_.cameras[c];
    outcome.serial = from.serial;
    outcome.was_straight = from.model == to.model;
    after = before_.of(from.serial);
    std::optional<Retaking> straighten;
    if (!outcome.was_straight) {
      straighten.emplace(from.model, to.model);
      after = added_to(*straighten, from.model, after);
      outcome.kept = share_kept(from.model, to.model);
      const PixelBox left = inside(after, to.model.width, to.model.height);
      outcome.hidden = 1 - static_cast<double>(left.width) * left.height / to.model.width / to.model.height;
      if (left.empty())
        return fail(ErrorCode::BadData, text("camera '", from.serial,
                                             "': its lens leaves nothing of a straight picture; calibrate "
                                             "it again, or leave it out when importing (--cameras)"));
    }
    const int rows = static_cast<int>(from_.rows(static_cast<int>(c)).size());
    for (int f = 0; f < rows; ++f) {
      if (is_cancelled(options_.progress)) return cancelled_unwritten();
      Result<Frame> frame = from_.frame(static_cast<int>(c), f);
      if (!frame) return forward(frame);
      frame->info.camera = static_cast<int>(c);
      frame->info.sequence = static_cast<std::uint64_t>(f);
      if (frame->empty()) frame->info.status = FrameStatus::Lost;
      if (straighten && !frame->empty()) {
        Result<Frame> made = straightened(*frame, *straighten, before_.of(from.serial));
        if (!made) return fail(made.error().code, text("camera '", from.serial, "': ", made.error().message));
        frame = std::move(made);
      }
      if (Result<void> ok = writer.write(*frame); !ok) return ok;
      part.advance();
    }
    if (Result<void> ok = mattes(from.serial, straighten ? &*straighten : nullptr); !ok) return ok;
    if (const fs::path mask = occluder_file(from_.layout(), from.serial); is_there(mask))
      if (Result<void> ok =
              picture(mask, occluder_file(to_, from.serial), straighten ? &*straighten : nullptr);
          !ok)
        return ok;
    return plates(from.serial, straighten ? &*straighten : nullptr);
  }

  Result<Frame> straightened(const Frame& frame, const Retaking& straighten,
                             const AddedContent& content) const {
    Result<Image> picture = to_rgb(frame);
    if (!picture) return forward(picture);
    // What was not hidden yet must not be drawn into what is around it.
    if (!hides_itself_ && !content.none()) picture = without(content, *std::move(picture));
    if (frame.layout.format == PixelFormat::Gray8) {
      Image grey(picture->width, picture->height, 1);
      for (std::size_t p = 0; p < grey.pixels.size(); ++p) grey.pixels[p] = picture->pixels[3 * p];
      picture = std::move(grey);
    }
    return make_frame(frame.info, straighten(*picture));
  }

  // The picture in a file as the straight camera would have taken it; the file itself of a straight one.
  Result<void> picture(const fs::path& from, const fs::path& to, const Retaking* straighten) {
    if (!straighten) {
      DerivedReport shared;
      return share_if_there(from, to, shared);
    }
    const Result<Image> image = load_png(from);
    if (!image) return forward(image);
    if (image->width != straighten->width() || image->height != straighten->height())
      return fail(ErrorCode::BadData, text(from.string(), ": is ", image->width, "x", image->height,
                                           ", but its camera's pictures are ", straighten->width(), "x",
                                           straighten->height(), "; remove it, or make it anew"));
    if (Result<void> ok = make_folder(to.parent_path()); !ok) return ok;
    return save_png((*straighten)(*image), to);
  }

  Result<void> mattes(const std::string& serial, const Retaking* straighten) {
    for (const int frame : from_.layout().frames_with_mattes(serial))
      if (Result<void> ok =
              picture(from_.layout().matte(serial, frame), to_.matte(serial, frame), straighten);
          !ok)
        return ok;
    return {};
  }

  Result<void> plates(const std::string& serial, const Retaking* straighten) {
    const fs::path from = from_.layout().plate(serial), to = to_.plate(serial);
    if (is_there(from))
      if (Result<void> ok = picture(from, to, straighten); !ok) return ok;
    std::error_code error;
    const fs::path several = from.parent_path() / serial;
    if (!fs::is_directory(several, error)) return {};
    for (const fs::directory_entry& entry : fs::directory_iterator(several, error))
      if (entry.path().extension() == ".png")
        if (Result<void> ok =
                picture(entry.path(), to.parent_path() / serial / entry.path().filename(), straighten);
            !ok)
          return ok;
    return {};
  }

  // What does not know of pixels, or only by its cameras.
  Result<void> carry() {
    const TakeLayout& from = from_.layout();
    DerivedReport shared;
    if (Result<void> ok = share_sound(from_, to_, shared); !ok) return ok;
    for (const auto& [file, to] : {std::pair(capture::time_code_file(from), capture::time_code_file(to_)),
                                   std::pair(capture::times_file(from), capture::times_file(to_))})
      if (Result<void> ok = share_if_there(file, to, shared); !ok) return ok;
    if (is_there(from.colors())) {
      Result<Rig> colors = load_rig(from.colors());
      if (!colors) return forward(colors);
      for (RigCamera& c : colors->cameras) c.model = straight(c.model);
      if (Result<void> ok = save_rig(*colors, to_.colors()); !ok) return ok;
    }
    std::error_code error;
    if (fs::is_directory(to_.mattes(), error))
      report_.notes.push_back("its mattes came along as given ones: they are used as they are");
    if (is_there(from.edits()))
      report_.notes.push_back("corrections of mattes were left out: they are in the mattes already");
    if (fs::is_directory(from.meshes(), error))
      report_.notes.push_back("its hulls were left out: run `floatstage process` again");
    return {};
  }

  Result<void> hide(const std::vector<AddedContent>& after) {
    capture::AddedFile added;
    for (std::size_t c = 0; c < after.size(); ++c)
      if (!after[c].none()) added.cameras[straight_.cameras[c].serial] = after[c];
    return capture::save_added(added, to_);
  }

  capture::TakeReader& from_;
  const UndistortOptions& options_;
  const TakeLayout to_;
  Rig straight_;
  capture::AddedFile before_;  // of the old take
  bool hides_itself_ = false;  // its reader does
  UndistortReport report_;
};

}  // namespace

PixelBox largest_box(const Image& mask) {
  PixelBox best;
  long most = 0;
  std::vector<int> above(static_cast<std::size_t>(mask.width), 0);  // pixels in a row upwards from this one
  std::vector<int> open;                                            // columns whose heights grow
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      int& height = above[static_cast<std::size_t>(x)];
      height = *mask.at(x, y) != 0 ? height + 1 : 0;
    }
    open.clear();
    for (int x = 0; x <= mask.width; ++x) {
      const int height = x < mask.width ? above[static_cast<std::size_t>(x)] : 0;
      while (!open.empty() && above[static_cast<std::size_t>(open.back())] >= height) {
        const int tall = above[static_cast<std::size_t>(open.back())];
        open.pop_back();
        const int left = open.empty() ? 0 : open.back() + 1;
        const long area = static_cast<long>(tall) * (x - left);
        if (area > most) most = area, best = {left, y - tall + 1, x - left, tall};
      }
      if (x < mask.width) open.push_back(x);
    }
  }
  return best;
}

Result<UndistortReport> undistort_take(const UndistortOptions& options) {
  std::vector<std::unique_ptr<capture::TakeReader>> takes;
  Result<std::unique_ptr<capture::TakeReader>> opened = capture::TakeReader::open(options.take);
  if (!opened) return forward(opened);
  takes.push_back(std::move(*opened));
  const std::vector<RigCamera>& cameras = takes.front()->rig().cameras;
  if (std::all_of(cameras.begin(), cameras.end(),
                  [](const RigCamera& c) { return c.model == straight(c.model); }))
    return fail(ErrorCode::InvalidArgument,
                text(options.take.string(),
                     ": no camera has a lens or a skew, so its pictures are straight already"));
  Result<UnfinishedFolder> take = UnfinishedFolder::begin(options.out);
  if (!take) return forward(take);
  std::vector<std::string> notes;
  const capture::TakeCodec codec = lossless_codec(takes, notes);
  Result<UndistortReport> report =
      Straightening(*takes.front(), options, take->folder()).run(codec, std::move(notes));
  if (!report) return report;
  if (const auto opens = capture::TakeReader::open(take->folder()); !opens) return forward(opens);
  if (Result<void> ok = take->publish(); !ok) return forward(ok);
  return report;
}

}  // namespace floatstage::pipeline
