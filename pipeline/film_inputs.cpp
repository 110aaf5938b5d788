#include "pipeline/film_inputs.h"

#include <set>

#include <nlohmann/json.hpp>

#include "capture/sha256.h"
#include "core/rig_io.h"
#include "pipeline/made_files.h"
#include "pipeline/matte_record.h"
#include "pipeline/mesh_record.h"

namespace floatstage::pipeline {
namespace {

using nlohmann::json;

// The bindings name every field: one that is added does not compile until it is thought of here.
json described(const render::FlowOptions& options) {
  const auto& [backend, preset, finest_scale, iterations, refinement, shrink, place] = options;
  return {backend, preset, finest_scale, iterations, refinement, shrink, static_cast<int>(place)};
}

json described(const render::RendererOptions& options) {
  const auto& [cameras, soft_radius, flow, positions, alignment, band_limit, nearest, farthest, uncertainty,
               motion_blur, field_memory, fill_hidden, sharp, soft_outlines, threads, back_end, background,
               output, shown_camera, towards_camera, given_up] = options;
  static_cast<void>(threads);      // pictures do not depend on it,
  static_cast<void>(fill_hidden);  // no film is without it,
  static_cast<void>(given_up);     // and those that are given up are in no film
  return {cameras,
          soft_radius,
          described(flow),
          static_cast<int>(positions),
          static_cast<int>(alignment),
          band_limit,
          nearest,
          farthest,
          uncertainty,
          motion_blur,
          field_memory,
          sharp,
          soft_outlines,
          static_cast<int>(back_end),
          background,
          static_cast<int>(output),
          shown_camera,
          towards_camera};
}

json described(const FilmOptions& options) {
  const auto& [width, height, frame_rate, seconds, frames, methods, array, suppress_spill, balance, subject,
               track, rig, pictures, block, renderer, time_stages, progress] = options;
  static_cast<void>(balance);  // is in the rig
  static_cast<void>(pictures);
  static_cast<void>(block);  // is in `drawn_by`
  static_cast<void>(time_stages);
  static_cast<void>(progress);
  const Eigen::Vector3d low = subject->min(), high = subject->max();
  json centres = json::array();
  for (const Eigen::Vector3d& c : track.value_or(SubjectTrack()).centres)
    centres.push_back({c.x(), c.y(), c.z()});
  return {width,
          height,
          frame_rate,
          seconds,
          frames,
          methods,
          array.views,
          array.baseline,
          suppress_spill,
          {low.x(), low.y(), low.z(), high.x(), high.y(), high.z()},
          std::move(centres),
          to_json(*rig),
          described(renderer)};
}

}  // namespace

Result<std::string> hash_of_film(const capture::TakeReader& take, const CameraPath& path,
                                 const FilmOptions& options, const std::string& drawn_by) {
  const Result<std::optional<std::string>> recording = hash_of(take.layout().manifest());
  if (!recording) return forward(recording);
  const Result<MatteRecord> mattes = load_matte_record(take.layout());
  if (!mattes) return forward(mattes);
  json keys = json::object();
  for (const auto& [serial, camera] : *mattes) keys[serial] = camera.key;
  return capture::sha256(
      json{recording->value_or(""), to_json(path), described(options), drawn_by, std::move(keys)}.dump());
}

Result<std::string> hash_of_scenes(const capture::TakeReader& take, const std::vector<int>& frames) {
  json scenes = json::array();
  for (const int frame : std::set<int>(frames.begin(), frames.end())) {
    const Result<std::optional<std::string>> mesh = hash_of(take.layout().mesh(frame));
    if (!mesh) return forward(mesh);
    const Result<MatteHashes> mattes = hashes_of_mattes(take.layout(), take.rig(), frame);
    if (!mattes) return forward(mattes);
    scenes.push_back({frame, mesh->value_or(""), *mattes});
  }
  return capture::sha256(scenes.dump());
}

}  // namespace floatstage::pipeline
