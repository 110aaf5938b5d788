#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "capture/take.h"
#include "core/mesh.h"
#include "core/result.h"
#include "recon/visual_hull.h"

namespace floatstage::pipeline {

/// What photographs are projected onto when renderers are scored.
struct Proxy {
  enum class Kind {
    Films,  ///< what films of the take are drawn on: a hull with the options of its meshes; its mesh where
            ///< nothing has mattes
    Hull,   ///< a hull with given options
    File,   ///< a mesh that knows nothing of who is held out
    Plane,  ///< across the cameras' mean viewing direction
  };
  Kind kind = Kind::Films;
  recon::HullOptions hull;     ///< Hull; and Films of a take whose meshes do not say how they were made
  std::filesystem::path file;  ///< File: PLY
  double distance = 0;         ///< Plane: metres before the cameras' mean place
};

/// "exact", "octree" (both: `hull` with this method), "plane:Z", or the name of a .ply file. InvalidArgument
/// says what there is.
Result<Proxy> parse_proxy(std::string_view words, const recon::HullOptions& hull);

/// The photographs and mattes of one instant, and what all held-out views of it share.
struct Instant {
  int frame = 0;
  FrameSet images;
  std::vector<Matte> mattes;     ///< by camera; empty ones where there are none
  bool any_matte = false;        ///< false: what is drawn is the whole of every photograph
  std::optional<Mesh> with_all;  ///< the proxy that leaves out nobody, once it is made
};

/// NotFound where `proxy` needs mattes or a mesh that the take has not.
Result<Instant> load_instant(capture::TakeReader& take, int frame, const Proxy& proxy);

/// The proxy of an instant without what camera `held` (-1: nobody) and those that are no `input` showed.
/// BadData for an empty one, InvalidArgument and Io as the proxy's makers.
Result<Mesh> proxy_without(const capture::TakeReader& take, Instant& instant, int held,
                           const std::vector<bool>& input, const Proxy& proxy);

}  // namespace floatstage::pipeline
