#include "apps/viewer/play/camera_frusta.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include <epoxy/gl.h>
#include <imgui.h>

namespace floatstage::apps {
namespace {

constexpr int kThumbnailWidth = 128;
constexpr float kLargest =
    0.4f;  // of the picture's width: we stand inside that camera, its frustum would hide the stage

// Box filter to a small picture: every source pixel counts once.
Image shrunk(const Image& rgb) {
  const int step = std::max(1, rgb.width / kThumbnailWidth);
  Image small(rgb.width / step, rgb.height / step, 3);
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        int sum = 0;
        for (int j = 0; j < step; ++j)
          for (int i = 0; i < step; ++i) sum += rgb.at(x * step + i, y * step + j)[c];
        small.at(x, y)[c] = static_cast<std::uint8_t>(sum / (step * step));
      }
    }
  }
  return small;
}

unsigned make_texture(const Image& rgb) {
  GLuint texture = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &texture);
  glTextureStorage2D(texture, 1, GL_RGB8, rgb.width, rgb.height);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(texture, 0, 0, 0, rgb.width, rgb.height, GL_RGB, GL_UNSIGNED_BYTE, rgb.pixels.data());
  glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  return texture;
}

// Apex and the four corners of a camera's image plane `depth` metres before it, on the screen.
std::optional<std::array<ImVec2, 5>> project_frustum(const RigCamera& camera, const View& view, double depth,
                                                     const ImVec2& origin, float scale) {
  const CameraModel& m = camera.model;
  const Rigid3 view_from_camera = view.view_from_world * camera.cam_from_world.inverse();
  const std::array<Eigen::Vector2d, 4> corners = {
      Eigen::Vector2d(0, 0), {m.width, 0}, {m.width, m.height}, {0, m.height}};
  std::array<ImVec2, 5> points;
  for (std::size_t i = 0; i < 5; ++i) {
    Eigen::Vector3d in_camera = Eigen::Vector3d::Zero();
    if (i > 0) {
      const std::optional<Eigen::Vector3d> ray = unproject(pinhole(m), corners[i - 1]);
      if (!ray) return std::nullopt;
      in_camera = *ray * depth;
    }
    const std::optional<Eigen::Vector2d> p = project(view.model, view_from_camera * in_camera);
    if (!p) return std::nullopt;
    points[i] =
        ImVec2(origin.x + static_cast<float>(p->x()) * scale, origin.y + static_cast<float>(p->y()) * scale);
  }
  return points;
}

}  // namespace

CameraFrusta::~CameraFrusta() {
  glDeleteTextures(static_cast<GLsizei>(thumbnails_.size()), thumbnails_.data());
}

void CameraFrusta::upload(const FrameSet& images) {
  glDeleteTextures(static_cast<GLsizei>(thumbnails_.size()), thumbnails_.data());
  thumbnails_.assign(images.frames.size(), 0);
  for (std::size_t i = 0; i < images.frames.size(); ++i)
    if (const Result<Image> rgb = to_rgb(images.frames[i])) thumbnails_[i] = make_texture(shrunk(*rgb));
}

void CameraFrusta::draw(ImDrawList* list, const ImVec2& origin, float scale, const Rig& rig, const View& view,
                        double depth, std::span<const int> used) const {
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    const auto points = project_frustum(rig.cameras[i], view, depth, origin, scale);
    if (!points) continue;
    const auto& [apex, a, b, c, d] = *points;
    if (std::abs(c.x - a.x) > kLargest * scale * static_cast<float>(view.model.width)) continue;
    const bool strong = std::find(used.begin(), used.end(), static_cast<int>(i)) != used.end();
    if (i < thumbnails_.size() && thumbnails_[i])
      list->AddImageQuad(reinterpret_cast<ImTextureID>(static_cast<std::intptr_t>(thumbnails_[i])), a, b, c,
                         d, {0, 0}, {1, 0}, {1, 1}, {0, 1},
                         strong ? IM_COL32(255, 255, 255, 235) : IM_COL32(255, 255, 255, 140));
    const ImU32 color = strong ? IM_COL32(255, 190, 60, 255) : IM_COL32(150, 170, 190, 200);
    for (const ImVec2& corner : {a, b, c, d}) list->AddLine(apex, corner, color, 1.2f);
    list->AddQuad(a, b, c, d, color, strong ? 2.f : 1.2f);
    list->AddText(ImVec2(apex.x + 4, apex.y + 2), color, rig.cameras[i].serial.c_str());
  }
}

}  // namespace floatstage::apps
