// SPDX-License-Identifier: Apache-2.0
// Surfaces in the forms that scanners and other programs write.
#include "physics/mesh/scan_io.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <string>

#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using ::testing::ElementsAre;

template <class T>
std::string Bytes(T value, bool swapped = false) {
  std::string bytes(reinterpret_cast<const char*>(&value), sizeof(value));
  if (swapped) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

class ScanIo : public FileFixture {
 protected:
  // The unit square of two triangles that share an edge.
  void ExpectSquare(const std::string& path) const {
    const ObjSurface surface = ReadSurface(path);
    ASSERT_EQ(surface.x.size(), 12) << path;
    ASSERT_EQ(surface.triangles.size(), 2u) << path;
    double area = 0.0;
    for (const auto& [a, b, c] : surface.triangles) {
      const Eigen::Vector3d p = surface.x.segment<3>(3 * a);
      const Eigen::Vector3d q = surface.x.segment<3>(3 * b) - p,
                            r = surface.x.segment<3>(3 * c) - p;
      area += 0.5 * q.cross(r).z();
    }
    EXPECT_DOUBLE_EQ(area, 1.0) << path;
  }
  static std::string Triangle(const std::string& a, const std::string& b, const std::string& c) {
    return " facet normal 0 0 1\n  outer loop\n   vertex " + a + "\n   vertex " + b +
           "\n   vertex " + c + "\n  endloop\n endfacet\n";
  }
  static std::string BinaryStl(uint32_t stated) {
    std::string text = "solid of a scanner that begins like text";
    text.resize(80, ' ');
    text += Bytes(stated);
    for (const auto& corners :
         {std::array{0.f, 0.f, 1.f, 0.f, 1.f, 1.f}, std::array{0.f, 0.f, 1.f, 1.f, 0.f, 1.f}}) {
      for (const float n : {0.f, 0.f, 1.f}) text += Bytes(n);
      for (int k = 0; k < 6; k += 2) text += Bytes(corners[k]) + Bytes(corners[k + 1]) + Bytes(0.f);
      text += Bytes(uint16_t{0});
    }
    return text;
  }
  // A header, with a colour, a list and an element that are not used.
  static std::string PlyHeader(const std::string& format, const std::string& vertices = "4") {
    return "ply\nformat " + format + " 1.0\ncomment made by a scanner\nelement vertex " + vertices +
           "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
           "element face 1\nproperty list uchar int vertex_indices\nproperty short flags\n"
           "element empty 4000000000\nelement camera 1\nproperty double focal\nend_header\n";
  }
  static std::string BinaryPly(bool swapped) {
    std::string text = PlyHeader(swapped ? "binary_big_endian" : "binary_little_endian");
    for (const auto& [x, y] : {std::pair(0.f, 0.f), {1.f, 0.f}, {1.f, 1.f}, {0.f, 1.f}})
      text += Bytes(x, swapped) + Bytes(y, swapped) + Bytes(0.f, swapped) + '\xC8';
    text += '\4';
    for (const int i : {0, 1, 2, 3}) text += Bytes(i, swapped);
    return text + Bytes(int16_t{-1}, swapped) + Bytes(35.0, swapped);
  }
};

TEST_F(ScanIo, ReadsStl) {
  const std::string faces =
      Triangle("0 0 0", "1 0 0", "1 1 0") + Triangle("0 0 0", "1.0e0 1 -0", "0 1 0");
  ExpectSquare(Write("text.stl", "solid scan\r\n" + faces + "endsolid scan\n"));
  ExpectSquare(Write("flat.STL", "solid\n" + faces + Triangle("0 0 0", "0 0 0", "1 0 0")));
  ExpectSquare(Write("binary.stl", BinaryStl(2)));
  EXPECT_INPUT_ERROR(ReadSurface(Write("cut.stl", BinaryStl(2).substr(0, 170))),
                     "cut.stl: the file has no faces");
  EXPECT_INPUT_ERROR(ReadSurface(Write("lie.stl", std::string(80, 'x') + Bytes(4000000000u))),
                     "lie.stl: found 84 bytes, expected text that begins with 'solid', or "
                     "200000000084 bytes of the 4000000000 triangles");
  EXPECT_INPUT_ERROR(ReadSurface(Write("bad.stl", "solid\nfacet\nvertex 1 2 x\n")),
                     "bad.stl:3: found 'x', expected a number");
  EXPECT_INPUT_ERROR(ReadSurface(Write("end.stl", "solid\nvertex 1 2 3\nvertex 1 2")),
                     "end.stl:3: the file ends early");
  EXPECT_INPUT_ERROR(
      ReadSurface(Write("inf.stl", "solid\n" + Triangle("0 0 0", "1 0 inf", "1 1 0"))),
      "is not finite");
}

TEST_F(ScanIo, ReadsPly) {
  ExpectSquare(Write("text.ply", PlyHeader("ascii") +
                                     "0 0 0 200\n1 0 0 200\n1 1 0 9\n0 1 0 9\n4 0 1 2 3 7\n35\n"));
  ExpectSquare(Write("little.ply", BinaryPly(false)));
  ExpectSquare(Write("big.ply", BinaryPly(true)));
  const auto expect = [&](const std::string& text, const std::string& problem) {
    EXPECT_INPUT_ERROR(ReadSurface(Write("bad.ply", text)), problem);
  };
  // What a header claims takes no memory.
  expect(PlyHeader("binary_little_endian", "2000000000") + "abc", "the file ends early");
  expect(PlyHeader("ascii", "9e99") + "1 2 3 4", "bad.ply:16: the file ends early");
  const std::string corners = PlyHeader("ascii") + "0 0 0 1 1 0 0 1 1 1 0 1 0 1 0 1 ";
  expect(PlyHeader("ascii") + "0 0 0 1\n1 0 0 1\n1 1 x 1", "bad.ply:18: found 'x', expected a");
  expect(corners + "4 0 1 2 4 7 35", "bad.ply: found a face of vertex 4, expected 0 … 3");
  expect(corners + "2 0 1 7 35", "bad.ply: found a face of 2 corners, expected 3 or more");
  expect(corners + "1e300 0 1 2", "the file ends early");
  expect(PlyHeader("ascii") + "0 0 nan 1 1 0 0 1 1 1 0 1 0 1 0 1 3 0 1 2 7 35", "is not finite");
  expect("ply\nelement vertex 1\nproperty half x\n", "bad.ply:3: found the type 'half'");
  expect("ply\nformat ascii 1.0\nfoo\n", "bad.ply:3: found 'foo'");
  expect("ply\nformat ascii 1.0\n", "found '', expected a line of a PLY header");
  const std::string header = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n";
  expect(header + "end_header\n1\n", "bad.ply: the element vertex has no y, expected x, y and z");
  const std::string point = header + "property float y\nproperty float z\nend_header\n1 2 3\n";
  expect(point, "the file has no faces");
  EXPECT_EQ(ReadVertices(Write("point.ply", point)), Eigen::Vector3d(1, 2, 3));
}

TEST_F(ScanIo, OtherFilesAreObj) {
  ExpectSquare(Write("a.OBJ", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"));
  EXPECT_TRUE(IsSurfaceFile("a.Ply") && IsSurfaceFile("b.stl") && IsSurfaceFile("c.obj"));
  EXPECT_FALSE(IsSurfaceFile("a.png") || IsSurfaceFile("ply"));
}

TEST(SplitPolygon, KeepsTheAreaOfAConcaveOne) {
  // An arrowhead: only the diagonal through the notch is inside.
  const std::vector<Eigen::Vector3d> arrow = {{0, 0, 1}, {2, 2, 1}, {0, 1, 1}, {-2, 2, 1}};
  EXPECT_THAT(SplitPolygon(arrow, "a"), ElementsAre(ElementsAre(0, 1, 2), ElementsAre(0, 2, 3)));
  std::vector<Eigen::Vector3d> turned = arrow;
  std::rotate(turned.begin(), turned.begin() + 1, turned.end());
  EXPECT_THAT(SplitPolygon(turned, "a"), ElementsAre(ElementsAre(1, 2, 3), ElementsAre(1, 3, 0)));
  // A zigzag that no corner sees whole.
  const std::vector<Eigen::Vector3d> zigzag = {{0, 0, 0}, {1, 0, 0},  {1, 2, 0},
                                               {2, 2, 0}, {2, 3, 0},  {0, 3, 0},
                                               {0, 1, 0}, {-1, 1, 0}, {-1, 0, 0}};
  EXPECT_INPUT_ERROR(SplitPolygon(zigzag, "a.obj:7"), "a.obj:7: found a face of 9 corners");
}

}  // namespace
}  // namespace drape
