#include "pipeline/evaluate/inputs.h"

#include <algorithm>
#include <charconv>
#include <string_view>

#include "core/text.h"
#include "render/camera_grid.h"

namespace floatstage::pipeline {
namespace {

constexpr std::string_view kEvery = "every:";

Result<int> find_camera(const Rig& rig, const std::string& name, const char* what_for) {
  if (const int i = camera_index(rig, name); i >= 0) return i;
  std::string known;
  for (const RigCamera& c : rig.cameras) known += (known.empty() ? "" : ", ") + c.serial;
  return fail(ErrorCode::NotFound,
              text("the take has no camera '", name, "' to ", what_for, "; it has ", known));
}

Result<int> step_of(const std::string& words) {
  const std::string_view number = std::string_view(words).substr(kEvery.size());
  int step = 0;
  const auto [stop, error] = std::from_chars(number.data(), number.data() + number.size(), step);
  if (error != std::errc() || stop != number.data() + number.size() || step < 1)
    return fail(ErrorCode::InvalidArgument,
                text("--inputs ", words, " names no cameras; write every:2 for every second one"));
  return step;
}

// In the middle between inputs that stand `step` rows or columns apart.
bool between(int place, int step, int count) {
  const int rest = place % step, last = (count - 1) / step * step;
  return place < last && (rest == step / 2 || rest == (step + 1) / 2);
}

void every(const Rig& rig, int step, Inputs& chosen) {
  const Result<render::CameraGrid> grid = render::camera_grid(rig.cameras);
  if (!grid) {
    for (std::size_t i = 0; i < rig.cameras.size(); ++i)
      chosen.input[i] = i % static_cast<std::size_t>(step) == 0;
    return;
  }
  for (int row = 0; row < grid->rows; ++row)
    for (int column = 0; column < grid->columns; ++column) {
      const int camera = grid->cameras[static_cast<std::size_t>(row * grid->columns + column)];
      chosen.input[static_cast<std::size_t>(camera)] = row % step == 0 && column % step == 0;
      if (step > 1 && between(row, step, grid->rows) && between(column, step, grid->columns))
        chosen.held.push_back(camera);
    }
}

}  // namespace

Result<Inputs> choose_inputs(const Rig& rig, const std::vector<std::string>& inputs,
                             const std::vector<std::string>& hold_out) {
  if (rig.cameras.size() < 3)
    return fail(ErrorCode::InvalidArgument, "leave-one-out needs a take of three cameras at least");
  Inputs chosen{std::vector<bool>(rig.cameras.size(), inputs.empty()), {}};
  if (inputs.size() == 1 && inputs.front().starts_with(kEvery)) {
    const Result<int> step = step_of(inputs.front());
    if (!step) return forward(step);
    every(rig, *step, chosen);
  } else {
    for (const std::string& name : inputs) {
      const Result<int> camera = find_camera(rig, name, "draw from");
      if (!camera) return forward(camera);
      chosen.input[static_cast<std::size_t>(*camera)] = true;
    }
  }
  if (!hold_out.empty()) chosen.held.clear();
  for (const std::string& name : hold_out) {
    const Result<int> camera = find_camera(rig, name, "hold out");
    if (!camera) return forward(camera);
    chosen.held.push_back(*camera);
  }
  if (chosen.held.empty())
    for (std::size_t i = 0; i < chosen.input.size(); ++i)
      if (!chosen.input[i]) chosen.held.push_back(static_cast<int>(i));
  if (chosen.held.empty())
    for (std::size_t i = 0; i < chosen.input.size(); ++i) chosen.held.push_back(static_cast<int>(i));
  const auto count = std::count(chosen.input.begin(), chosen.input.end(), true);
  const bool takes_one = std::any_of(chosen.held.begin(), chosen.held.end(),
                                     [&](int i) { return chosen.input[static_cast<std::size_t>(i)]; });
  if (count - (takes_one ? 1 : 0) < 2)
    return fail(
        ErrorCode::InvalidArgument,
        text("--inputs leaves fewer than two cameras to draw from; the take has ", rig.cameras.size()));
  return chosen;
}

}  // namespace floatstage::pipeline
