#include "pipeline/picture_sink.h"

#include <cstdio>

#include "capture/alpha_video.h"
#include "capture/media_file.h"
#include "core/claim.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/png.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

class VideoSink : public PictureSink {
 public:
  explicit VideoSink(std::unique_ptr<capture::VideoWriter> writer) : writer_(std::move(writer)) {}
  Result<void> write(const Image& picture) override { return writer_->write(picture); }
  Result<void> finish() override { return writer_->finish(); }

 private:
  std::unique_ptr<capture::VideoWriter> writer_;
};

class FolderSink : public PictureSink {
 public:
  FolderSink(fs::path out, Claim claim)
      : out_(std::move(out)), temporary_(temporary_name(out_)), claim_(std::move(claim)) {}
  ~FolderSink() override {
    std::error_code ignored;
    if (!finished_) fs::remove_all(temporary_, ignored);
  }
  Result<void> write(const Image& picture) override {
    char name[16];
    std::snprintf(name, sizeof name, "%06d.png", count_++);
    return save_png(picture, temporary_ / name);
  }
  Result<void> finish() override {
    if (Result<void> ok = rename_new(temporary_, out_); !ok) return ok;
    finished_ = true;
    return {};
  }

 private:
  const fs::path out_, temporary_;
  const Claim claim_;
  int count_ = 0;
  bool finished_ = false;
};

bool is_video(const fs::path& out) {
  const fs::path extension = out.extension();
  return extension == ".mp4" || extension == ".mkv" || extension == ".mov";
}

}  // namespace

fs::path film_name(const fs::path& out) {
  return out.has_filename() || !out.has_parent_path() ? out : out.parent_path();
}

Result<void> check_film_name(const fs::path& out, bool with_opacity) {
  if (is_there(out))
    return fail(ErrorCode::AlreadyExists,
                text(out.string(), " exists already; choose another --out or remove it"));
  if (out.has_extension() && !is_video(out))
    return fail(ErrorCode::InvalidArgument,
                text(out.string(), ": name a .mp4, .mkv or .mov video, or a folder for PNGs"));
  if (with_opacity && is_video(out) && out.extension() != ".mov")
    return fail(ErrorCode::InvalidArgument,
                text(out.string(),
                     ": H.264 holds no opacity; name a .mov video (ProRes 4444), or a folder for PNGs"));
  return {};
}

Result<std::unique_ptr<PictureSink>> open_picture_sink(const fs::path& given, int width, int height,
                                                       double frame_rate, bool with_opacity) {
  const fs::path out = film_name(given);
  if (Result<void> ok = check_film_name(out, with_opacity); !ok) return forward(ok);
  if (is_video(out)) {
    Result<std::unique_ptr<capture::VideoWriter>> writer =
        with_opacity ? capture::create_alpha_video(out, width, height, frame_rate)
                     : capture::VideoWriter::create(out, width, height, frame_rate);
    if (!writer) return forward(writer);
    // Once more, now that nobody else can write it.
    if (Result<void> ok = check_film_name(out, with_opacity); !ok) return forward(ok);
    return std::unique_ptr<PictureSink>(std::make_unique<VideoSink>(std::move(*writer)));
  }
  Result<Claim> claim = claim_temporary_folder(out);
  if (!claim) return forward(claim);
  return std::unique_ptr<PictureSink>(std::make_unique<FolderSink>(out, std::move(*claim)));
}

}  // namespace floatstage::pipeline
