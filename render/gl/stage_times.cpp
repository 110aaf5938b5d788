#include "render/gl/stage_times.h"

#include <algorithm>

#include "core/check.h"

namespace floatstage::render::gl {
namespace {

thread_local StageTimes* recorder = nullptr;

}  // namespace

StageTimes::StageTimes() {
  FLOATSTAGE_CHECK(recorder == nullptr, "one StageTimes a thread");
  recorder = this;
}

StageTimes::~StageTimes() {
  recorder = nullptr;
  for (const Mark& mark : marks_) free_.push_back(mark.query);
  glDeleteQueries(static_cast<GLsizei>(free_.size()), free_.data());
}

void StageTimes::enter(const char* stage) {
  if (recorder != nullptr) recorder->mark(stage);
}

void StageTimes::count(std::size_t bytes) {
  if (recorder == nullptr || recorder->marks_.empty()) return;
  ++recorder->marks_.back().dispatches;
  recorder->marks_.back().bytes += bytes;
}

void StageTimes::mark(const char* stage) {
  if (free_.empty()) {
    free_.resize(1);
    glCreateQueries(GL_TIMESTAMP, 1, free_.data());
  }
  marks_.push_back({stage, free_.back(), 0, 0});
  free_.pop_back();
  glQueryCounter(marks_.back().query, GL_TIMESTAMP);
}

std::vector<StageTime> StageTimes::take() {
  mark("");
  std::vector<StageTime> stages;
  GLuint64 before = 0;
  for (std::size_t i = 0; i < marks_.size(); ++i) {
    GLuint64 now = 0;
    glGetQueryObjectui64v(marks_[i].query, GL_QUERY_RESULT, &now);
    if (i > 0) {
      const Mark& mark = marks_[i - 1];
      auto stage = std::find_if(stages.begin(), stages.end(),
                                [&](const StageTime& s) { return s.name == mark.stage; });
      if (stage == stages.end()) stage = stages.insert(stages.end(), StageTime{mark.stage});
      stage->milliseconds += static_cast<double>(now - before) * 1e-6;
      stage->dispatches += mark.dispatches;
      stage->least_megabytes += static_cast<double>(mark.bytes) * 1e-6;
    }
    before = now;
    free_.push_back(marks_[i].query);
  }
  marks_.clear();
  return stages;
}

}  // namespace floatstage::render::gl
