#include "core/mesh_io.h"

#include <algorithm>
#include <cstring>

#include <gtest/gtest.h>

#include "core/file.h"
#include "core/text.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage {
namespace {

using testing::ElementsAre;

Result<Mesh> parse(std::string_view ply) { return parse_ply(std::as_bytes(std::span(ply)), "test.ply"); }

Mesh tetrahedron() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1.5f}}, {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2}};
}

constexpr std::string_view kAsciiQuad =
    "ply\r\nformat ascii 1.0\r\ncomment a scanner wrote this\r\nobj_info too\r\n"
    "element vertex 4\r\nproperty uchar red\r\nproperty double z\r\nproperty float y\r\nproperty list uchar "
    "int neighbours\r\n"
    "property float32 x\r\nelement odd 2\r\nproperty list uint8 float many\r\nelement face 1\r\n"
    "property list uchar int vertex_index\r\nproperty int material\r\nend_header\r\n"
    "9 0 0 1 7 0\r\n9 0 0 0 +1\r\n9 0.25 1 2 7 7 1e0\r\n9 0 1 0 0\r\n3 1 2 3\r\n0\r\n4 0 1 2 3 5\r\n";

TEST(Ply, ReadsForeignPropertiesAndCutsPolygonsIntoFans) {
  const Result<Mesh> mesh = parse(kAsciiQuad);
  ASSERT_THAT(mesh, IsOk());
  EXPECT_THAT(mesh->positions, ElementsAre(Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(1, 0, 0),
                                           Eigen::Vector3f(1, 1, 0.25f), Eigen::Vector3f(0, 1, 0)));
  EXPECT_THAT(mesh->triangles, ElementsAre(0, 1, 2, 0, 2, 3));
}

// A triangle with faces before vertices, doubles and shorts, in the byte order asked for.
std::string binary_triangle(bool big_endian) {
  std::string ply =
      text("ply\nformat binary_", big_endian ? "big" : "little",
           "_endian 1.0\nelement face 1\nproperty list ushort uint vertex_indices\nelement vertex 3\n"
           "property double x\nproperty double y\nproperty short z\nend_header\n");
  auto put = [&](auto value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    if (big_endian) std::reverse(bytes, bytes + sizeof value);
    ply.append(bytes, sizeof value);
  };
  put(std::uint16_t{3});
  for (std::uint32_t i : {2u, 0u, 1u}) put(i);
  for (int i = 0; i < 3; ++i) {
    put(0.5 * i);
    put(-2.0);
    put(static_cast<std::int16_t>(-300 * i));
  }
  return ply;
}

class BinaryPly : public testing::TestWithParam<bool> {};

TEST_P(BinaryPly, IsReadInEitherByteOrderAndElementOrder) {
  const Result<Mesh> mesh = parse(binary_triangle(GetParam()));
  ASSERT_THAT(mesh, IsOk());
  EXPECT_THAT(mesh->positions, ElementsAre(Eigen::Vector3f(0, -2, 0), Eigen::Vector3f(0.5f, -2, -300),
                                           Eigen::Vector3f(1, -2, -600)));
  EXPECT_THAT(mesh->triangles, ElementsAre(2, 0, 1));
}

TEST_P(BinaryPly, CutOffAnywhereIsRefused) {
  const std::string whole = binary_triangle(GetParam());
  for (std::size_t length = 0; length < whole.size(); ++length)
    EXPECT_THAT(parse(std::string_view(whole).substr(0, length)), FailsWith(ErrorCode::BadData, "test.ply"))
        << length;
}

INSTANTIATE_TEST_SUITE_P(ByteOrders, BinaryPly, testing::Bool());

TEST(Ply, OfPointsAloneIsAMeshWithoutTriangles) {
  const auto mesh = parse(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float "
      "z\nend_header\n1 2 3\n");
  ASSERT_THAT(mesh, IsOk());
  EXPECT_TRUE(mesh->empty());
  EXPECT_EQ(mesh->positions.size(), 1u);
}

struct Broken {
  const char* from;
  const char* to;
  const char* complaint;
};

class BrokenPly : public testing::TestWithParam<Broken> {};

TEST_P(BrokenPly, IsRefusedWithASentence) {
  std::string ply(kAsciiQuad);
  const std::size_t at = ply.find(GetParam().from);
  ASSERT_NE(at, std::string::npos);
  ply.replace(at, std::strlen(GetParam().from), GetParam().to);
  EXPECT_THAT(parse(ply), FailsWith(ErrorCode::BadData, text("test.ply: ", GetParam().complaint)));
}

INSTANTIATE_TEST_SUITE_P(
    Breakages, BrokenPly,
    testing::Values(Broken{"ply", "plx", "not a PLY file"},
                    Broken{"format ascii 1.0", "comment", "the PLY header states no format"},
                    Broken{"ascii 1.0", "ascii 2.0", "line 2 of the PLY header makes no sense"},
                    Broken{"double z", "quad z", "line 7 of the PLY header"},
                    Broken{"uchar int n", "float int n", "line 9 of the PLY header"},
                    Broken{"vertex 4", "vertex four", "line 5 of the PLY header"},
                    Broken{"vertex 4", "point 4", "the PLY has no vertices"},
                    Broken{"double z", "double w", "the vertices have no x, y and z"},
                    Broken{"vertex_index", "corners", "the faces have no list"},
                    Broken{"element odd", "element vertex", "the PLY has two lists of vertices"},
                    Broken{"vertex 4", "vertex 400000000000", "more than 4294967295 vertices"},
                    Broken{"vertex 4", "vertex 4000000000", "the data of vertex"},
                    Broken{"face 1", "face 9999999999999999", "the data of face 1 of"},
                    Broken{"0.25", "nan", "the position of vertex 2 is not finite"},
                    Broken{"0.25", "1e300", "the position of vertex 2 is not finite"},
                    Broken{"0.25", "0.25m", "the data of vertex 2 of 4"},
                    Broken{"4 0 1 2 3", "4 0 1 2 4", "a face names vertex 4 of 4"},
                    Broken{"4 0 1 2 3", "4 0 1 2 -1", "face 0 names a vertex that cannot exist"},
                    Broken{"4 0 1 2 3", "4 0 1 2 1.5", "face 0 names a vertex that cannot exist"},
                    Broken{"4 0 1 2 3", "2 0 1 2 3", "face 0 has 2 corners"},
                    Broken{"4 0 1 2 3", "-4 0 1 2 3", "the data of face 0 of 1"}));

TEST(PlyFile, ComesBackFromTheDiskBitByBit) {
  const TempFolder folder;
  ASSERT_THAT(save_ply(tetrahedron(), folder / "000012.ply"), IsOk());
  const Result<Mesh> back = load_ply(folder / "000012.ply");
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(back->positions, tetrahedron().positions);
  EXPECT_EQ(back->triangles, tetrahedron().triangles);
  EXPECT_THAT(folder.names(), ElementsAre("000012.ply"));
}

TEST(PlyFile, OfNothingIsAFileOfNothing) {
  const TempFolder folder;
  ASSERT_THAT(save_ply(Mesh{}, folder / "empty.ply"), IsOk());
  const Result<Mesh> back = load_ply(folder / "empty.ply");
  ASSERT_THAT(back, IsOk());
  EXPECT_TRUE(back->empty() && back->positions.empty());
}

TEST(PlyFile, ThatIsNotThereIsNotFound) {
  EXPECT_THAT(load_ply("/nowhere/a.ply"), FailsWith(ErrorCode::NotFound, "/nowhere/a.ply"));
}

std::uint32_t word(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

TEST(GlbFile, HoldsOneJsonAndOneBinaryChunkOfTheStatedSizes) {
  const TempFolder folder;
  ASSERT_THAT(save_glb(tetrahedron(), folder / "mesh.glb"), IsOk());
  const Result<std::string> glb = read_file(folder / "mesh.glb");
  ASSERT_THAT(glb, IsOk());
  ASSERT_GT(glb->size(), 20u);
  EXPECT_EQ(glb->substr(0, 4), "glTF");
  EXPECT_EQ(word(*glb, 4), 2u);
  EXPECT_EQ(word(*glb, 8), glb->size());
  const std::uint32_t json_size = word(*glb, 12);
  EXPECT_EQ(glb->substr(16, 4), "JSON");
  const std::string json = glb->substr(20, json_size);
  EXPECT_THAT(json, testing::HasSubstr("\"POSITION\""));
  EXPECT_THAT(json, testing::HasSubstr("\"rotation\":[-0.707106"));
  ASSERT_GE(glb->size(), 28 + json_size);
  EXPECT_EQ(glb->substr(24 + json_size, 3), "BIN");
  EXPECT_EQ(word(*glb, 20 + json_size), 4 * 12u + 12 * 4u);
  Eigen::Vector3f last;
  std::memcpy(last.data(), glb->data() + 28 + json_size + 3 * 12, 12);
  EXPECT_EQ(last, Eigen::Vector3f(0, 0, 1.5f));
}

TEST(GlbFile, OfNothingStillHasAScene) {
  const TempFolder folder;
  ASSERT_THAT(save_glb(Mesh{}, folder / "mesh.glb"), IsOk());
  EXPECT_THAT(read_file(folder / "mesh.glb"), IsOkAnd(testing::HasSubstr("\"scenes\"")));
}

}  // namespace
}  // namespace floatstage
