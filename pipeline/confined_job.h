#pragma once

#include <functional>
#include <string>

#include <nlohmann/json.hpp>

#include "core/confined.h"
#include "core/text.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// run_confined() of a job that is watched: its progress is shown by `progress`, and cancelling that ends the
/// child, as Cancelled with nothing written. The job's own Progress is cancelled where `limits` gives it time
/// to end by itself, and what it then says is the error.
Result<std::string> run_confined_bytes(const Confinement& limits, Progress* progress,
                                       const std::function<Result<std::string>(Progress*)>& job);

/// The same of a job with a report. BadData where the child gives none that can be read.
template <class Report>
Result<Report> run_confined_job(const Confinement& limits, Progress* progress,
                                const std::function<Result<Report>(Progress*)>& job) {
  using nlohmann::json;
  // As bytes: names of files need not be UTF-8, which JSON's text must be.
  const Result<std::string> bytes =
      run_confined_bytes(limits, progress, [&](Progress* told) -> Result<std::string> {
        const Result<Report> report = job(told);
        if (!report) return forward(report);
        std::string packed;
        json::to_msgpack(json(*report), packed);
        return packed;
      });
  if (!bytes) return forward(bytes);
  const json packed = json::from_msgpack(*bytes, /*strict=*/true, /*allow_exceptions=*/false);
  try {
    return packed.get<Report>();
  } catch (const json::exception&) {
    return fail(ErrorCode::BadData, text(limits.what, ": what decodes it gave no report that can be read"));
  }
}

}  // namespace floatstage::pipeline
