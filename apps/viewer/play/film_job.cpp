#include "apps/viewer/play/film_job.h"

#include "pipeline/picture_sink.h"
#include "render/back_end.h"

namespace floatstage::apps {

FilmJob::FilmJob(std::filesystem::path take, pipeline::LabelChoice labels, pipeline::CameraPath path,
                 pipeline::FilmOptions options, std::filesystem::path out) {
  future_ = std::async(
      std::launch::async,
      [this, take = std::move(take), labels = std::move(labels), path = std::move(path),
       options = std::move(options), out = std::move(out)] { return run(take, labels, path, options, out); });
}

FilmJob::~FilmJob() { give_up_ = true; }  // the future's destructor waits for the thread

bool FilmJob::done() const {
  return future_.valid() && future_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

Result<pipeline::FilmReport> FilmJob::result() { return future_.get(); }

Result<pipeline::FilmReport> FilmJob::run(const std::filesystem::path& folder,
                                          const pipeline::LabelChoice& labels,
                                          const pipeline::CameraPath& path,
                                          const pipeline::FilmOptions& options,
                                          const std::filesystem::path& out) {
  Result<std::unique_ptr<capture::TakeReader>> take = pipeline::open_chosen(folder, labels);
  if (!take) return forward(take);
  const Result<render::OpenBackEnd> drawing = render::open_back_end(options.renderer.back_end);
  if (!drawing) return forward(drawing);
  Result<std::unique_ptr<pipeline::PictureSink>> sink =
      pipeline::open_picture_sink(out, options.width, options.height, options.frame_rate);
  if (!sink) return forward(sink);
  Result<pipeline::FilmReport> report =
      pipeline::render_film(**take, path, options, [&](pipeline::FilmPicture picture) -> Result<void> {
        if (give_up_) return fail(ErrorCode::Cancelled, "the film was given up");
        ++pictures_;
        return (*sink)->write(pipeline::over(picture.renders.front(), options.renderer.background));
      });
  if (!report) return report;
  if (Result<void> ok = (*sink)->finish(); !ok) return forward(ok);
  return report;
}

}  // namespace floatstage::apps
