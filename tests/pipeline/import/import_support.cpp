#include "tests/pipeline/import/import_support.h"

#include <cstdio>

#include <gtest/gtest.h>

#include "core/png.h"

namespace floatstage::pipeline {

Image test_picture(int camera, int frame, int width, int height) {
  Image image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      std::uint8_t* p = image.at(x, y);
      p[0] = static_cast<std::uint8_t>(20 + 50 * camera);
      p[1] = static_cast<std::uint8_t>(20 + 40 * frame);
      p[2] = static_cast<std::uint8_t>(5 * x + y);
    }
  return image;
}

Rig test_rig(int cameras) {
  Rig rig;
  for (int i = 0; i < cameras; ++i) {
    RigCamera c;
    c.serial = std::string(1, static_cast<char>('a' + i));
    c.model.width = kImportWidth;
    c.model.height = kImportHeight;
    c.model.fx = c.model.fy = 40;
    c.model.cx = 16.25;
    c.model.cy = 11.75;
    c.cam_from_world = look_at({2.0, 0.5 * i - 0.5, 1.0}, {0, 0, 1}, Eigen::Vector3d::UnitZ());
    rig.cameras.push_back(c);
  }
  return rig;
}

void save_pictures(const std::filesystem::path& folder, int camera, int count) {
  std::filesystem::create_directories(folder);
  for (int frame = 0; frame < count; ++frame) {
    char name[32];
    std::snprintf(name, sizeof name, "%06d.png", frame);
    const Result<void> saved = save_png(test_picture(camera, frame), folder / name);
    ASSERT_TRUE(saved.has_value()) << saved.error().message;
  }
}

}  // namespace floatstage::pipeline
