#include "render/stage_times.h"

#include <algorithm>

#include <epoxy/gl.h>

#include "core/check.h"

namespace floatstage::render {
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
      add({{mark.stage, static_cast<double>(now - before) * 1e-6, mark.dispatches,
            static_cast<double>(mark.bytes) * 1e-6}},
          stages);
    }
    before = now;
    free_.push_back(marks_[i].query);
  }
  marks_.clear();
  return stages;
}

void add(const std::vector<StageTime>& stages, std::vector<StageTime>& sums) {
  for (const StageTime& stage : stages) {
    auto sum =
        std::find_if(sums.begin(), sums.end(), [&](const StageTime& s) { return s.name == stage.name; });
    if (sum == sums.end()) sum = sums.insert(sums.end(), StageTime{stage.name});
    sum->milliseconds += stage.milliseconds;
    sum->dispatches += stage.dispatches;
    sum->least_megabytes += stage.least_megabytes;
  }
}

}  // namespace floatstage::render
