#include "render/cpu/field_maker.h"

#include <algorithm>
#include <atomic>
#include <optional>

#include "core/text.h"
#include "render/cpu/position_shares.h"

namespace floatstage::render::cpu {
namespace {

constexpr int kMargin = 16;  // px around the proxy: fields are continued beyond it

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Of a camera of the rig, among the scene's.
std::optional<int> in_scene(const Scene::Impl& s, int camera) {
  const auto found = std::find(s.rig_index.begin(), s.rig_index.end(), camera);
  if (found == s.rig_index.end()) return std::nullopt;
  return static_cast<int>(found - s.rig_index.begin());
}

// Those that are kept for these options.
FieldSet& fields_of(const Scene::Impl& scene, const FlowOptions& flow) {
  for (FieldSet& set : scene.fields)
    if (same_fields(set.flow, flow)) return set;
  FieldSet& made = scene.fields.emplace_back();
  if (scene.given_fields && same_fields(scene.given_fields->flow, flow)) made = *scene.given_fields;
  made.flow = flow;
  return made;
}

}  // namespace

// Photograph `from` and what `to` shows there, as views that blend the two see them.
Result<void> FieldMaker::project(const Scene& scene, const RendererOptions& options, Job& job) {
  const Scene::Impl& s = scene.impl();
  RendererOptions plain;
  plain.soft_radius = 0;
  plain.threads = options.threads;
  plain.given_up = options.given_up;
  CameraChoice both;
  for (int camera : {job.pair.from, job.pair.to}) {
    const std::optional<int> slot = in_scene(s, camera);
    if (!slot)
      return fail(ErrorCode::InvalidArgument,
                  text("a field of camera ", camera, ", which has no picture in this scene"));
    both.listed.push_back(*slot);
    both.fade.push_back(1);
    both.stand_in_fade.push_back(1);
  }
  both.chosen = 2;
  const View view = field_view(s.cameras[at(both.listed[0])], s.box);
  if (Result<void> ok =
          projection_.run(scene, view, plain, {.margin = kMargin, .images = true, .cameras = &both});
      !ok)
    return ok;
  job.field = {};
  const Window& window = projection_.window();
  if (window.empty()) return {};
  projection_.gray_images(options.flow.shrink, job.images);
  const double shrink = options.flow.shrink;
  const CameraModel& m = view.model;
  job.field.place = {static_cast<float>(m.fx / shrink), static_cast<float>(m.fy / shrink),
                     static_cast<float>((m.cx - window.x) / shrink),
                     static_cast<float>((m.cy - window.y) / shrink)};
  job.field.width = job.images.width;
  job.field.height = job.images.height;
  return {};
}

Result<void> FieldMaker::run(const Scene& scene, std::span<const CameraPair> pairs,
                             const RendererOptions& options, FieldSet& made) {
  jobs_.resize(std::max(jobs_.size(), pairs.size()));
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    jobs_[i].pair = pairs[i];
    if (Result<void> ok = project(scene, options, jobs_[i]); !ok) return ok;
  }
  Interruption interruption;
  interruption.begin(options.given_up);
  const std::size_t workers =
      std::min(pairs.size(), at(options.threads > 0 ? options.threads : default_threads()));
  if (workers_.size() < workers) workers_.resize(workers);
  std::vector<Result<void>> ended(pairs.size(), Result<void>());
  std::atomic<std::size_t> next = 0;
  parallel_for(workers, options.threads, [&](std::size_t worker) {
    for (std::size_t i; (i = next.fetch_add(1)) < pairs.size();) {
      Job& job = jobs_[i];
      if (job.field.width == 0) continue;
      ended[i] = workers_[worker].estimate(job.images, {true, true}, options.flow, 1, &interruption);
      if (ended[i]) job.field.uv = to_steps(workers_[worker].fields()[0].uv);
    }
  });
  if (interruption.given_up()) return given_up();
  for (const Result<void>& ok : ended)
    if (!ok) return ok;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    made.fields[pairs[i]] = std::make_shared<const CameraField>(std::move(jobs_[i].field));
  return {};
}

Result<ChosenFields> chosen_fields(const Scene& scene, const CameraChoice& choice,
                                   const RendererOptions& options, FieldMaker& maker) {
  const Scene::Impl& s = scene.impl();
  FieldSet& made = fields_of(s, options.flow);
  auto pair_of = [&](std::size_t from, std::size_t to) {
    return CameraPair{s.rig_index[at(choice.listed[from])], s.rig_index[at(choice.listed[to])]};
  };
  std::vector<CameraPair> missing;
  for (std::size_t from = 0; from < choice.chosen; ++from)
    for (std::size_t to = 0; to < choice.chosen; ++to) {
      const CameraPair pair = pair_of(from, to);
      if (from != to && choice.fade[to] >= kLeastFade && !made.fields.contains(pair)) missing.push_back(pair);
    }
  if (!missing.empty())
    if (Result<void> ok = maker.run(scene, missing, options, made); !ok) return forward(ok);
  ChosenFields chosen;
  for (std::size_t from = 0; from < choice.chosen; ++from)
    for (std::size_t to = 0; to < choice.chosen; ++to) {
      const auto found = made.fields.find(pair_of(from, to));
      if (found != made.fields.end() && found->second->width > 1)
        chosen[static_cast<std::size_t>(kMostListed) * from + to] = found->second;
    }
  return chosen;
}

}  // namespace floatstage::render::cpu

namespace floatstage::render {

Result<FieldSet> estimate_fields(const Scene& scene, std::span<const CameraPair> pairs,
                                 const RendererOptions& options) {
  FieldSet made{options.flow, {}};
  cpu::FieldMaker maker;
  if (Result<void> ok = maker.run(scene, pairs, options, made); !ok) return forward(ok);
  return made;
}

}  // namespace floatstage::render
