#include "pipeline/picture_sink.h"

#include <cstdio>

#include "capture/media_file.h"
#include "core/file.h"
#include "core/png.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

class VideoSink : public PictureSink {
 public:
  explicit VideoSink(std::unique_ptr<capture::VideoWriter> writer) : writer_(std::move(writer)) {}
  Result<void> write(const Image& rgb) override { return writer_->write(rgb); }
  Result<void> finish() override { return writer_->finish(); }

 private:
  std::unique_ptr<capture::VideoWriter> writer_;
};

class FolderSink : public PictureSink {
 public:
  FolderSink(fs::path out, fs::path temporary) : out_(std::move(out)), temporary_(std::move(temporary)) {}
  ~FolderSink() override {
    std::error_code ignored;
    if (!finished_) fs::remove_all(temporary_, ignored);
  }
  Result<void> write(const Image& rgb) override {
    char name[16];
    std::snprintf(name, sizeof name, "%06d.png", count_++);
    return save_png(rgb, temporary_ / name);
  }
  Result<void> finish() override {
    std::error_code error;
    fs::rename(temporary_, out_, error);
    if (error)
      return fail(ErrorCode::Io,
                  text("cannot rename the pictures to ", out_.string(), ": ", error.message()));
    finished_ = true;
    return {};
  }

 private:
  const fs::path out_, temporary_;
  int count_ = 0;
  bool finished_ = false;
};

}  // namespace

Result<std::unique_ptr<PictureSink>> open_picture_sink(const fs::path& out, int width, int height,
                                                       double frame_rate) {
  if (fs::exists(out))
    return fail(ErrorCode::AlreadyExists,
                text(out.string(), " exists already; choose another --out or remove it"));
  const fs::path extension = out.extension();
  if (extension == ".mp4" || extension == ".mkv" || extension == ".mov") {
    Result<std::unique_ptr<capture::VideoWriter>> writer =
        capture::VideoWriter::create(out, width, height, frame_rate);
    if (!writer) return forward(writer);
    return std::unique_ptr<PictureSink>(std::make_unique<VideoSink>(std::move(*writer)));
  }
  if (!extension.empty())
    return fail(ErrorCode::InvalidArgument,
                text(out.string(), ": name a .mp4, .mkv or .mov video, or a folder for PNGs"));
  const fs::path temporary = temporary_name(out);
  std::error_code error;
  fs::remove_all(temporary, error);
  if (Result<void> ok = make_folder(temporary); !ok) return forward(ok);
  return std::unique_ptr<PictureSink>(std::make_unique<FolderSink>(out, temporary));
}

}  // namespace floatstage::pipeline
