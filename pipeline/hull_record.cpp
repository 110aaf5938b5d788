#include "pipeline/hull_record.h"

#include <charconv>

#include <nlohmann/json.hpp>

#include "core/text.h"

namespace floatstage::pipeline {

Result<recon::HullOptions> hull_options(const HullWords& words) {
  recon::HullOptions options = words.options;
  if (words.method == "exact") {
    options.method = recon::HullMethod::Exact;
  } else if (words.method == "octree") {
    options.method = recon::HullMethod::Octree;
  } else {
    return fail(ErrorCode::InvalidArgument, text("--hull '", words.method, "' is neither exact nor octree"));
  }
  if (words.votes == "strict") {
    options.voting = recon::HullVoting::Strict;
  } else if (words.votes == "auto") {
    options.voting = recon::HullVoting::Auto;
  } else {
    options.voting = recon::HullVoting::MofN;
    const char* end = words.votes.data() + words.votes.size();
    const auto [stop, error] = std::from_chars(words.votes.data(), end, options.votes);
    if (error != std::errc() || stop != end || options.votes < 2) {
      return fail(
          ErrorCode::InvalidArgument,
          text("--votes '", words.votes, "' is neither strict, auto nor a number of at least 2 cameras"));
    }
  }
  if (!words.volume.empty()) {
    options.volume = Eigen::AlignedBox3d(Eigen::Vector3d(words.volume[0], words.volume[1], words.volume[2]),
                                         Eigen::Vector3d(words.volume[3], words.volume[4], words.volume[5]));
  }
  if (Result<void> ok = check(options); !ok) return forward(ok);
  return options;
}

nlohmann::json describe(const recon::HullOptions& options) {
  nlohmann::json j;
  if (options.method == recon::HullMethod::Octree) {
    j = {{"method", "octree"}, {"resolution", options.resolution}, {"smoothing", options.smoothing}};
  } else {
    j = {{"method", "exact"}, {"contour_tolerance", options.contour_tolerance}};
    if (options.voting == recon::HullVoting::MofN) {
      j["votes"] = options.votes;
    } else {
      j["votes"] = options.voting == recon::HullVoting::Auto ? "auto" : "strict";
    }
  }
  if (options.keep_crumbs) j["keep_crumbs"] = true;
  if (options.volume) {
    const Eigen::Vector3d a = options.volume->min(), b = options.volume->max();
    j["volume"] = {a.x(), a.y(), a.z(), b.x(), b.y(), b.z()};
  }
  if (options.cleanup.wanted()) {
    const recon::MeshCleanup& cleanup = options.cleanup;
    j["cleanup"] = {{"collapse_slivers", cleanup.collapse_slivers},
                    {"smooth", cleanup.smooth},
                    {"triangles", cleanup.triangles},
                    {"pixels", cleanup.largest_move},
                    {"loss", cleanup.largest_loss}};
  }
  return j;
}

std::optional<recon::HullOptions> parse_hull_options(const nlohmann::json& description) {
  try {
    const nlohmann::json& j = description;
    HullWords words;
    words.method = j.at("method").get<std::string>();
    words.options.resolution = j.value("resolution", words.options.resolution);
    words.options.smoothing = j.value("smoothing", words.options.smoothing);
    words.options.contour_tolerance = j.value("contour_tolerance", words.options.contour_tolerance);
    words.options.keep_crumbs = j.value("keep_crumbs", false);
    if (j.contains("votes"))
      words.votes = j["votes"].is_string() ? j["votes"].get<std::string>() : j["votes"].dump();
    if (j.contains("volume")) words.volume = j["volume"].get<std::vector<double>>();
    if (j.contains("cleanup")) {
      recon::MeshCleanup& cleanup = words.options.cleanup;
      const nlohmann::json& c = j["cleanup"];
      cleanup.collapse_slivers = c.value("collapse_slivers", cleanup.collapse_slivers);
      cleanup.smooth = c.value("smooth", cleanup.smooth);
      cleanup.triangles = c.value("triangles", cleanup.triangles);
      cleanup.largest_move = c.value("pixels", cleanup.largest_move);
      cleanup.largest_loss = c.value("loss", cleanup.largest_loss);
    }
    if (!words.volume.empty() && words.volume.size() != 6) return std::nullopt;
    Result<recon::HullOptions> options = hull_options(words);
    if (!options) return std::nullopt;
    return *options;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;  // a word that is missing or of another kind
  }
}

}  // namespace floatstage::pipeline
