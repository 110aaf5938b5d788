#pragma once

#include <memory>
#include <string>

#include "studio/messages/camera_view.h"

namespace floatstage::studio {

/// A view with an outline of an island with a hole, and a tile whose matte has soft edges.
inline CameraView small_view(const std::string& serial, std::uint64_t epoch = 7) {
  CameraView view;
  view.serial = serial;
  view.epoch = epoch;
  view.instant = {1'000'000'000 + static_cast<std::int64_t>(epoch) * 40'000'000};
  view.exposed = view.instant + Nanoseconds{123};
  view.produced = view.instant + milliseconds(9);
  view.width = 64;
  view.height = 48;
  view.known = true;
  view.outline.points = {{10.25, 8.5}, {30.0, 8.0}, {30.5, 40.125}, {9.0, 39.0},
                         {15, 15},     {15, 20},    {20, 20}};
  view.outline.starts = {0, 4, 7};
  auto tile = std::make_shared<ForegroundTile>();
  tile->x = 9;
  tile->y = 8;
  tile->picture = Image(22, 33, 3);
  tile->matte = Image(22, 33, 1);
  for (int y = 0; y < 33; ++y)
    for (int x = 0; x < 22; ++x) {
      for (int c = 0; c < 3; ++c)
        tile->picture.at(x, y)[c] = static_cast<std::uint8_t>(40 + 3 * x + 2 * y + 20 * c);
      *tile->matte.at(x, y) = x < 2 ? static_cast<std::uint8_t>(x * 90 + y) : x < 19 ? 255 : 0;
    }
  view.tile = std::move(tile);
  return view;
}

}  // namespace floatstage::studio
