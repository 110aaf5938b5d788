#include "pipeline/matte/doubt_sheet.h"

#include <algorithm>
#include <optional>

#include "matting/doubt_picture.h"
#include "pipeline/scene_loader.h"
#include "recon/silhouette_agreement.h"

namespace floatstage::pipeline {
namespace {

constexpr std::size_t kMostTiles = 12;
constexpr int kTile = 480;  // px
constexpr int kFewestOthers = 3;

}  // namespace

Result<Image> doubt_sheet(capture::TakeReader& take, const std::vector<int>& cameras, int frame) {
  Result<std::vector<Matte>> mattes = load_mattes(take, frame);
  if (!mattes) return forward(mattes);
  const auto there = std::count_if(mattes->begin(), mattes->end(), [](const Matte& m) { return !m.empty(); });
  std::vector<Image> tiles;
  for (const int camera : cameras) {
    const auto i = static_cast<std::size_t>(camera);
    if (tiles.size() >= kMostTiles || (*mattes)[i].empty()) continue;
    const Result<Frame> photograph = take.frame(camera, frame);
    if (!photograph || photograph->empty()) continue;
    const Result<Image> rgb = to_rgb(*photograph);
    if (!rgb) continue;
    const std::optional<Matte> others =
        there > kFewestOthers ? recon::silhouette_of_others(take.rig(), *mattes, i) : std::nullopt;
    tiles.push_back(matting::doubt_tile(*rgb, (*mattes)[i], others, kTile));
  }
  return tiles.empty() ? Image() : matting::contact_sheet(tiles);
}

}  // namespace floatstage::pipeline
