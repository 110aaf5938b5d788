#include <algorithm>
#include <array>
#include <cmath>

#include "core/random.h"
#include "render/camera_block.h"
#include "render/view_window.h"
#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

TEST(PinholeBounds, HoldTheWholePictureOfACurvedLens) {
  RigCamera camera;
  camera.model = small_camera();
  camera.model.lens = BrownConrady{-0.3, 0.1, 0.001, -0.002, 0};
  camera.cam_from_world = on_orbit(0);
  const Eigen::AlignedBox3f everything(Eigen::Vector3f::Constant(-10), Eigen::Vector3f::Constant(10));
  const Eigen::AlignedBox2d bounds = render::pinhole_bounds(camera, everything, 0);
  for (int y = 0; y <= 120; y += 5)
    for (int x = 0; x <= 160; x += 5) {
      const auto ray = unproject(camera.model, {x, y});
      ASSERT_TRUE(ray.has_value());
      EXPECT_TRUE(bounds.contains(Eigen::Vector2d(ray->head<2>()))) << x << ' ' << y;
    }
}

TEST(PinholeBounds, NeverReachFartherThanTheSubject) {
  RigCamera camera;
  camera.model = small_camera();
  camera.cam_from_world = on_orbit(0, 0);
  const Eigen::AlignedBox3f small(Eigen::Vector3f::Constant(-0.1F), Eigen::Vector3f::Constant(0.1F));
  EXPECT_LT(render::pinhole_bounds(camera, small, 0).sizes().maxCoeff(), 0.25);
}

TEST(LargestRadius, EndsWhereTheLensTurnsBack) {
  EXPECT_GT(render::largest_radius2(std::monostate{}), 1e10);
  const BrownConrady barrel{-0.3, 0, 0, 0, 0};  // r - 0.3 r³ rises until r² = 1 / 0.9
  EXPECT_NEAR(render::largest_radius2(barrel), 1 / 0.9, 0.01);
}

TEST(WindowOf, HoldsTheMeshWithItsMargin) {
  const View view = view_at(0);
  const Mesh mesh = ball(0.1F, 12);
  const Window w = window_of(view, mesh.positions, 10);
  for (const Eigen::Vector3f& p : mesh.positions) {
    const auto pixel = project(view.model, view.view_from_world * Eigen::Vector3d(p.cast<double>()));
    EXPECT_GE(pixel->x(), w.x + 10);
    EXPECT_LE(pixel->x(), w.x + w.width - 10);
    EXPECT_GE(pixel->y(), w.y + 10);
    EXPECT_LE(pixel->y(), w.y + w.height - 10);
  }
  EXPECT_LT(w.width, 110);
}

TEST(WindowOf, IsEmptyWhenTheMeshIsNotInThePicture) {
  View view = view_at(0);
  view.view_from_world = look_at({1, 0, 0}, {2, 0, 0}, Eigen::Vector3d::UnitZ());  // away from it
  EXPECT_TRUE(render::window_of(view, ball(0.1F, 6).positions, 0).empty());
  view.view_from_world = look_at({1, 0, 0}, {0, 3, 0}, Eigen::Vector3d::UnitZ());  // past it
  EXPECT_TRUE(render::window_of(view, ball(0.1F, 6).positions, 0).empty());
}

Window window_by_blocks(const View& view, const std::vector<Eigen::Vector3f>& positions, int margin) {
  VertexBlocks blocks;
  blocks.set(positions);
  return window_of(view, positions, blocks, margin);
}

std::array<int, 4> numbers(const Window& w) { return {w.x, w.y, w.width, w.height}; }

/// From anywhere near a mesh: around it, among its vertices, past it and away from it.
View any_view(Random& random) {
  const auto point = [&](double reach) {
    return Eigen::Vector3d(random.uniform(-reach, reach), random.uniform(-reach, reach),
                           random.uniform(-reach, reach));
  };
  View view = view_at(0, 10, small_camera(320, 240));
  view.view_from_world =
      look_at(point(random.next() % 2 ? 0.4 : 3), point(random.next() % 4 ? 0.1 : 1), point(1));
  view.near_plane = random.next() % 2 ? 0.01 : 0.5;
  return view;
}

TEST(WindowOf, IsTheSameByBlocksFromEverywhere) {
  Random random(3);
  Mesh strips = ball(0.25F, 30, 0.6F), mixed = strips, far = strips;
  for (std::size_t i = mixed.positions.size() - 1; i > 0; --i)
    std::swap(mixed.positions[i], mixed.positions[random.next() % (i + 1)]);
  for (Eigen::Vector3f& p : far.positions) p += Eigen::Vector3f(4e3F, -2e4F, 7);  // coordinates of a map
  int empty = 0, whole = 0, other = 0;
  for (int i = 0; i < 3000; ++i) {
    View view = any_view(random);
    for (const Mesh* mesh : {&strips, &mixed, &far}) {
      SCOPED_TRACE(testing::Message() << "view " << i);
      View here = view;
      if (mesh == &far)
        here.view_from_world = view.view_from_world * Rigid3{Eigen::Quaterniond::Identity(), {-4e3, 2e4, -7}};
      const Window expected = window_of(here, mesh->positions, i % 20);
      ASSERT_EQ(numbers(window_by_blocks(here, mesh->positions, i % 20)), numbers(expected));
      ++(expected.empty() ? empty : expected.width >= 320 && expected.height >= 240 ? whole : other);
    }
  }
  EXPECT_GT(std::min({empty, whole, other}), 300);
}

TEST(WindowOf, IsTheSameByBlocksForAnyNumberOfVertices) {
  const std::vector<Eigen::Vector3f> all = ball(0.25F, 9).positions;
  for (std::size_t count = 0; count <= all.size(); ++count) {
    const std::vector<Eigen::Vector3f> some(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count));
    EXPECT_EQ(numbers(window_by_blocks(view_at(20), some, 4)), numbers(window_of(view_at(20), some, 4)))
        << count;
  }
}

TEST(WindowOf, IsTheWholeViewForOneVertexBeforeTheNearPlane) {
  View view = view_at(0, 0);
  view.near_plane = 0.5;
  std::vector<Eigen::Vector3f> positions = ball(0.1F, 12).positions;
  positions.resize(positions.size() / VertexBlocks::kVertices * VertexBlocks::kVertices);
  positions.resize(positions.size() + VertexBlocks::kVertices, {0, 0, 0});
  positions.back() = {0.7F, 0, 0};  // 0.3 m away, in the middle of the picture, in a block without width
  const Window window = window_by_blocks(view, positions, 10);
  EXPECT_EQ(numbers(window), numbers(window_of(view, positions, 10)));
  EXPECT_GT(window.width, 160);
}

// A wall that fills the window to its last bit: many vertices share the extreme coordinates.
TEST(WindowOf, IsTheSameByBlocksForAWallOnTheGridOfWindows) {
  View view;
  view.model = small_camera(320, 240);
  view.model.fx = view.model.fy = 128;
  for (const double shift : {0.0, 1e-7, -1e-7, 0.3}) {
    std::vector<Eigen::Vector3f> wall;
    for (int y = -16; y <= 16; ++y)
      for (int x = -32; x <= 32; ++x) wall.emplace_back(x / 32.F + static_cast<float>(shift), y / 32.F, 1.F);
    EXPECT_EQ(numbers(window_by_blocks(view, wall, 0)), numbers(window_of(view, wall, 0))) << shift;
  }
}

class Geometry : public OnEachBackEnd {};
FLOATSTAGE_ON_EACH_BACK_END(Geometry);

// The half-pixel test: a square with known corners covers exactly its pixels.
TEST_P(Geometry, ASquareCoversExactlyItsPixels) {
  CameraModel model = small_camera(64, 48);
  Stage stage{{}, {}};
  RigCamera camera;
  camera.serial = "front";
  camera.model = model;
  stage.rig.cameras = {camera};  // at the world's origin, looking along +z
  Image photo(64, 48, 3, 10);
  for (int y = 12; y < 30; ++y)
    for (int x = 20; x < 45; ++x) photo.at(x, y)[0] = static_cast<std::uint8_t>(100 + x + y);
  stage.scene.images.frames = {make_frame({}, photo)};
  auto corner = [&](double u, double v) {
    return Eigen::Vector3f(Eigen::Vector3d(*unproject(model, {u, v}) * 2).cast<float>());
  };
  stage.scene.mesh.positions = {corner(20, 12), corner(45, 12), corner(45, 30), corner(20, 30)};
  stage.scene.mesh.triangles = {0, 2, 1, 0, 3, 2};
  View view;
  view.model = model;
  for (const char* method : {"nearest", "linear", "floating"}) {
    const Image picture = rendered(stage, view, method);
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 64; ++x) {
        const bool inside = x >= 20 && x < 45 && y >= 12 && y < 30;
        ASSERT_EQ(picture.at(x, y)[3], inside ? 255 : 0) << method << ' ' << x << ' ' << y;
        const int expected = inside ? 100 + x + y : 0;
        ASSERT_EQ(picture.at(x, y)[0], expected) << method << ' ' << x << ' ' << y;
      }
  }
}

TEST_P(Geometry, ADistortedPhotographGivesThePictureOfAPinholeOne) {
  CameraModel lens = small_camera();
  for (const Lens& kind :
       {Lens(BrownConrady{-0.25, 0.08, 0.002, -0.001, 0.01}), Lens(KannalaBrandt{0.05, -0.02, 0.01, 0})}) {
    lens.lens = kind;
    const Mesh mesh = ball(0.25F, 48);
    const Stage straight = photographed(arc(3, 20), mesh, mesh),
                curved = photographed(arc(3, 20, lens), mesh, mesh);
    const Image a = rendered(straight, view_at(6), "linear"), b = rendered(curved, view_at(6), "linear");
    EXPECT_GT(psnr(a, b, [&](int x, int y) { return well_inside(a, x, y, 3); }), 28);
    const Stage ignored = [&] {
      Stage s = curved;
      for (RigCamera& camera : s.rig.cameras) camera.model = pinhole(camera.model);
      return s;
    }();
    const Image wrong = rendered(ignored, view_at(6), "linear");
    EXPECT_LT(psnr(a, wrong, [&](int x, int y) { return well_inside(a, x, y, 3); }), 26)
        << "the lens makes no difference";
  }
}

TEST_P(Geometry, AHiddenPartIsNotPaintedWithWhatHidesIt) {
  // A red plate before a green wall; the camera on the left sees red where the view sees the wall.
  Stage stage{arc(2, 40), {}};
  Mesh mesh;
  auto plate = [&](float x, float half) {
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    for (const auto& [y, z] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)})
      mesh.positions.push_back({x, half * static_cast<float>(y), half * static_cast<float>(z)});
    mesh.triangles.insert(mesh.triangles.end(), {base, base + 1, base + 2, base, base + 2, base + 3});
  };
  plate(0, 0.25F);
  plate(0.3F, 0.05F);
  const SolidColor color = [](const Eigen::Vector3f& p) {
    return p.x() > 0.15F ? Eigen::Vector3f(255, 0, 0) : Eigen::Vector3f(0, 255, 0);
  };
  for (const RigCamera& camera : stage.rig.cameras)
    stage.scene.images.frames.push_back(
        make_frame({}, photograph(mesh, camera.model, camera.cam_from_world, 1, color).rgb));
  stage.scene.mesh = mesh;
  const View view = view_at(2);
  const Photograph truth = photograph(mesh, view.model, view.view_from_world, 1, color);
  for (const char* method : {"nearest", "linear", "floating"}) {
    const Image picture = rendered(stage, view, method);
    int wrong = 0, wall = 0;
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 160; ++x) {
        bool all_green = well_inside(picture, x, y, 2);
        for (int v = -2; v <= 2 && all_green; ++v)
          for (int u = -2; u <= 2; ++u) all_green = all_green && truth.rgb.at(x + u, y + v)[1] == 255;
        if (!all_green) continue;
        ++wall;
        wrong += picture.at(x, y)[0] > 60;
      }
    EXPECT_GT(wall, 1000);
    EXPECT_LT(wrong, wall / 100) << method;
  }
}

TEST_P(Geometry, AColorOutsideTheMatteIsNotUsedWhereAnotherCameraKnowsBetter) {
  // The proxy is fatter than the subject: beyond its silhouette the photographs show a loud background.
  const Mesh subject = ball(0.2F, 48), proxy = ball(0.22F, 24);
  Stage stage{arc(5, 20), {}};
  for (const RigCamera& camera : stage.rig.cameras) {
    const Photograph p = photograph(
        subject, camera.model, camera.cam_from_world, 3,
        [](const Eigen::Vector3f&) { return Eigen::Vector3f(120, 120, 120); }, Eigen::Vector3f(0, 255, 0));
    stage.scene.images.frames.push_back(make_frame({}, p.rgb));
    stage.scene.mattes.push_back(make_matte({}, p.alpha));
  }
  stage.scene.mesh = proxy;
  auto loud = [&] {
    const Image picture = rendered(stage, view_at(0), "linear");
    int count = 0;
    for (std::size_t i = 0; i < picture.pixels.size(); i += 4)
      count += picture.pixels[i + 3] > 0 && picture.pixels[i + 1] > 180;
    return count;
  };
  const int with_mattes = loud();
  stage.scene.mattes.clear();
  EXPECT_LT(with_mattes, 0.7 * loud());
}

TEST_P(Geometry, EveryIntermediateCanBeShown) {
  const Stage stage = photographed(arc(5, 20), ball(0.25F, 24), ball(0.265F, 24));
  for (int output = 0; output < static_cast<int>(render::render_output_names().size()); ++output) {
    render::RendererOptions options;
    options.output = static_cast<RenderOutput>(output);
    const Image picture = rendered(stage, view_at(7), "floating", options);
    int covered = 0, colored = 0;
    for (std::size_t i = 0; i < picture.pixels.size(); i += 4) {
      covered += picture.pixels[i + 3] > 0;
      colored +=
          picture.pixels[i + 3] > 0 && picture.pixels[i] + picture.pixels[i + 1] + picture.pixels[i + 2] > 0;
    }
    EXPECT_GT(covered, 1500) << render::render_output_names()[static_cast<std::size_t>(output)];
    EXPECT_GT(colored, covered / 2) << render::render_output_names()[static_cast<std::size_t>(output)];
  }
}

}  // namespace
}  // namespace floatstage::render
