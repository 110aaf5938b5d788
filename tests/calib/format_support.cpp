#include "tests/calib/format_support.h"

#include "core/text.h"

namespace floatstage::calib {

Rig sample_rig(const Lens& lens, bool tiny) {
  Rig rig;
  for (int i = 0; i < 3; ++i) {
    RigCamera c;
    c.serial = text("cam", i);
    c.model = tiny ? CameraModel{.width = 2, .height = 2, .fx = 3, .fy = 3, .cx = 1, .cy = 1, .lens = lens}
                   : CameraModel{.width = 640,
                                 .height = 480,
                                 .fx = 800.25 + i,
                                 .fy = 801.0 / 3 + i,
                                 .cx = 322.7,
                                 .cy = 231.1,
                                 .lens = lens};
    c.cam_from_world = look_at({2.5 - i, -1.5 + 2 * i, 1.2}, {0.1, 0, 0.9}, Eigen::Vector3d::UnitZ());
    rig.cameras.push_back(c);
  }
  return rig;
}

void expect_same(const Rig& a, const Rig& b, double tolerance) {
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  for (std::size_t i = 0; i < a.cameras.size(); ++i) {
    const RigCamera &x = a.cameras[i], &y = b.cameras[i];
    EXPECT_EQ(x.serial, y.serial);
    if (y.model.width != 0) {
      EXPECT_EQ(x.model.width, y.model.width);
      EXPECT_EQ(x.model.height, y.model.height);
    }
    EXPECT_TRUE(x.model.k().isApprox(y.model.k(), tolerance)) << x.model.k() << "\n" << y.model.k();
    EXPECT_EQ(x.model.lens, y.model.lens) << x.serial;
    EXPECT_LT((x.cam_from_world.matrix() - y.cam_from_world.matrix()).cwiseAbs().maxCoeff(), tolerance)
        << x.serial;
  }
}

}  // namespace floatstage::calib
