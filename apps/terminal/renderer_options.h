#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "core/result.h"
#include "render/renderer.h"

namespace floatstage::apps {

/// The renderer's options as flags, the same for every verb that renders.
struct RendererFlags {
  render::RendererOptions options;
  const CLI::Option* blend = nullptr;  ///< --blend, to ask whether it was said
  bool balance = false;
  std::string depth_range;                ///< NEAR:FAR
  std::string show_camera, show_towards;  ///< serials; empty: the renderer's own choice
  std::string show = "color", positions = "parallax", alignment = "flow", background = "000000",
              back_end = "auto";
};

void add_renderer_flags(CLI::App& verb, RendererFlags& flags);
/// --alignment, --renderer alone, for verbs that choose the rest by themselves.
CLI::Option* add_alignment(CLI::App& verb, std::string& alignment);
void add_back_end_flag(CLI::App& verb, std::string& back_end);
Result<render::RendererOptions> renderer_options(const RendererFlags& flags);

/// What of the options depends on the cameras: which of them are shown; and without --blend as many
/// photographs as suit them, four of a grid, whose cells have so many corners. InvalidArgument for a serial
/// that is none of theirs.
Result<void> suit_cameras(const RendererFlags& flags, const Rig& rig, render::RendererOptions& options);

/// "Method:" and a line for each of render::renderers().
std::string method_help();

}  // namespace floatstage::apps
