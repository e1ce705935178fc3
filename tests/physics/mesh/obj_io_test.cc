// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/obj_io.h"

#include <string>

#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using ::testing::ElementsAre;

class ObjIo : public FileFixture {
 protected:
  Mesh Parse(const std::string& text, const ObjOptions& options = {}) const {
    return ReadObj(Write("cloth.obj", text), options);
  }

  void ExpectError(const std::string& text, const std::string& message) const {
    EXPECT_INPUT_ERROR(Parse(text), message);
  }
};

constexpr char kSquare[] = "v 0 0 0\nv .1 0 0\nv .1 .2 0\nv 0 .2 0\n";

TEST_F(ObjIo, ReadsEachFormOfCorner) {
  const std::string head =
      std::string(kSquare) + "vt 0 0\nvt .1 0 0\nvt .1 .2\nvt 0 .2\nvn 0 0 1\n";
  for (const char* faces :
       {"f 1 2 3\nf 1 3 4\n", "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n",
        "f 1//1 2//1 3//1\nf 1//1 3//1 4//1\n", "f 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/4/1",
        "f -4 -3 -2\nf -4/-4/-1 -2/-2/-1 -1/-1/-1\n"}) {
    const Mesh mesh = Parse(head + faces);
    ASSERT_EQ(mesh.num_faces(), 2) << faces;
    EXPECT_THAT(mesh.faces[0].vertex, ElementsAre(0, 1, 2)) << faces;
    EXPECT_THAT(mesh.faces[1].vertex, ElementsAre(0, 2, 3)) << faces;
    EXPECT_DOUBLE_EQ(mesh.faces[0].area, .01);
  }
}

TEST_F(ObjIo, SkipsCommentsGroupsAndCarriageReturns) {
  const Mesh mesh = Parse(
      "# head\r\nmtllib a.mtl\r\no cloth\r\n\r\n  v\t0 0 0  # first\r\n"
      "v +1e-1 0 0\r\nv 0 .1 0\r\ng g\r\ns off\r\nusemtl m\r\nf 1 2 3\r\n");
  EXPECT_DOUBLE_EQ(mesh.faces[0].area, .005);
}

TEST_F(ObjIo, TakesMaterialCoordinatesFromVt) {
  const Mesh mesh = Parse("v 0 0 5\nv 1 0 6\nv 0 1 7\nvt 0 1\nvt .5 0\nvt 1.5 0\nf 1/2 2/3 3/1\n");
  EXPECT_EQ(mesh.uv.col(0), Eigen::Vector2d(.5, 0));
  EXPECT_EQ(mesh.uv.col(2), Eigen::Vector2d(0, 1));
  EXPECT_EQ(mesh.rest_x.segment<3>(3), Eigen::Vector3d(1, 0, 6));
}

TEST_F(ObjIo, TakesMaterialCoordinatesFromXyOfAFlatMesh) {
  const std::string seam = "v 0 0 2\nv 1 0 2\nv 1 1 2\nv 0 1 2\nvt 0 0\nvt 1 0\nvt 1 1\n";
  const Mesh mesh = Parse(seam + "f 1/1 2/2 3/3\nf 1/2 3/3 4/1\n");
  EXPECT_EQ(mesh.uv.col(3), Eigen::Vector2d(0, 1));
  EXPECT_EQ(mesh.rest_x[2], 2);
}

TEST_F(ObjIo, RejectsAMeshWithoutMaterialCoordinates) {
  ExpectError(
      "v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n",
      "cloth.obj: no material coordinates: a corner has no vt (line 4), and z is not constant");
  ExpectError(
      "v 0 0 0\nv 1 0 0\nv 1 1 1\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
      "f 1/1 2/2 3/3\nf 1/2 3/3 4/4\n",
      "cloth.obj: no material coordinates: vertex 1 has two different vt (line 10)");
}

TEST_F(ObjIo, TakesXyOfAFlatMeshForTextureCoordinates) {
  const std::string tail = "vt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
  for (const char* size : {".3", "3", ".8"}) {  // .8: within twice a metre
    const std::string s = size, flat = "v 0 0 0\nv " + s + " 0 0\nv 0 " + s + " ";
    testing::internal::CaptureStderr();
    EXPECT_EQ(Parse(flat + "0\n" + tail).uv(0, 1), std::stod(s));
    EXPECT_THAT(testing::internal::GetCapturedStderr(),
                testing::HasSubstr("cloth.obj: vt is not in metres: its mean edge is 1.138"));
    ExpectError(flat + ".1\n" + tail, "cloth.obj: vt is not in metres: its mean edge is 1.138");
  }
  EXPECT_EQ(Parse("v 0 0 0\nv .98 0 0\nv 0 .98 0\n" + tail).uv(0, 1), 1);  // a stretched cloth
}

TEST_F(ObjIo, RefusesAClothInAnotherUnit) {
  ExpectError("v 0 0 0\nv 300 0 0\nv 0 300 0\nf 1 2 3\n",
              "cloth.obj: extent: found 300 m, expected about 0.01 … 5 m; in cm it would be 3, in "
              "mm it would be 0.3 m");
}

// What Blender, MeshLab, 3ds Max and ARCSim write beside triangles.
TEST_F(ObjIo, ReadsTheDialectsOfOtherPrograms) {
  for (const char* text :
       {"\xEF\xBB\xBFv 0 0 0\nv .1 0 0\nv .1 .2 0\nv 0 .2 0\nf 1 2 3\nf 1 3 4\n",
        "v 0 0 0 .5 .4 .3\nv .1 0 0 1 1 1\nv .1 .2 0 0 0 0 1\nv 0 .2 0 1.0\nf 1 2 3 4\n",
        "# C:\\scans\\\nv 0 0 0\nv .1 0 0\nv .1 .2 0\nv 0 .2 \\\r\n 0\r\nf 1 2 \\\n3 \\\n4\n",
        "mtllib a.mtl\nusemap off\nlod 1\nv 0 0 0\nv .1 0 0\nv .1 .2 0\nv 0 .2 0\nl 1 2 3\np 4\n"
        "g\nf 1 2 3 4"}) {
    testing::internal::CaptureStderr();
    const Mesh mesh = Parse(text);
    ASSERT_EQ(mesh.num_faces(), 2) << text;
    EXPECT_DOUBLE_EQ(mesh.faces[0].area, .01) << text;
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  }
  testing::internal::CaptureStderr();
  EXPECT_EQ(Parse(std::string(kSquare) + "e 1 2\nnl a\ne 2 3\nf 1 2 3 4\n").num_faces(), 2);
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              testing::HasSubstr("cloth.obj: skipped lines that begin with 'e', 'nl'\n"));
  // Corners keep their vt, and a line is that on which its face begins.
  const Mesh quad = Parse(
      "v 0 0 1\nv 1 0 2\nv 1 1 3\nv 0 1 4\nvt 0 0\nvt 1.5 0\nvt 1.5 1.5\nvt 0 1.5\n"
      "f 1/1 2/2 3/3 4/4\n");
  EXPECT_EQ(quad.uv.col(3), Eigen::Vector2d(0, 1.5));
  ExpectError(std::string(kSquare) + "f 1 2 \\\n3 9\n", "cloth.obj:5: v index 9");
}

TEST_F(ObjIo, RoundsToFloatOnRequest) {
  const std::string text =
      "v .1 0 0\nv .2 0 0\nv .1 .3 0\nvt .1 0\nvt .2 0\nvt .1 .3\n"
      "f 1/1 2/2 3/3\n";
  const Mesh exact = Parse(text), rounded = Parse(text, {.round_to_float = true});
  EXPECT_EQ(exact.rest_x[0], .1);
  EXPECT_EQ(rounded.rest_x[0], double{.1f});
  EXPECT_EQ(rounded.uv(1, 2), double{.3f});
  EXPECT_INPUT_ERROR(Parse("v 1e300 0 0\n", {.round_to_float = true}),
                     "cloth.obj:1: '1e300' is not a finite number");
}

TEST_F(ObjIo, SkipsADummyFirstVt) {
  const std::string text =
      "v 0 0 1\nv 1 0 2\nv 0 1 3\nvt 0 0\nvt .1 0\nvt 1.1 0\nvt .1 1\n"
      "f 1/1 2/2 3/3\n";
  const Mesh mesh = Parse(text, {.first_vt_is_dummy = true});
  EXPECT_EQ(mesh.uv.col(0), Eigen::Vector2d(.1, 0));
  EXPECT_EQ(mesh.uv.col(2), Eigen::Vector2d(.1, 1));
}

TEST_F(ObjIo, TurnsAClockwiseMeshOver) {
  const Mesh mesh = Parse(std::string(kSquare) + "f 1 3 2\nf 1 4 3\n");
  EXPECT_THAT(mesh.faces[0].vertex, ElementsAre(0, 1, 2));
  EXPECT_THAT(mesh.faces[1].vertex, ElementsAre(0, 2, 3));
}

TEST_F(ObjIo, RejectsMixedOrientation) {
  ExpectError(std::string(kSquare) + "f 1 2 3\nf 1 4 3\n",
              "cloth.obj:6: the face is oriented opposite");
  ExpectError(std::string(kSquare) + "f 1 3 2\nf 1 3 4\n",
              "cloth.obj:6: the face is oriented opposite");
}

TEST_F(ObjIo, NamesTheLineOfABadLine) {
  ExpectError("v 0 0\n", "cloth.obj:1: 'v' has 2 numbers, expected 3");
  ExpectError("v 0 0 0\n\nv 0 0 0 1 1\n", "cloth.obj:3: 'v' has 5 numbers, expected 3, 4, 6 or 7");
  ExpectError("v 0 0 0 2\n", "cloth.obj:1: w is 2, expected 1 or none");
  ExpectError("vt 0\n", "cloth.obj:1: 'vt' has 1 numbers, expected 2 or 3");
  ExpectError("vn 0 1\n", "cloth.obj:1: 'vn' has 2 numbers, expected 3");
  ExpectError("v 0 0 nan\n", "cloth.obj:1: 'nan' is not a finite number");
  ExpectError("v 0 -inf 0\n", "cloth.obj:1: '-inf' is not a finite number");
  ExpectError("v 0 1e999 0\n", "cloth.obj:1: '1e999' is not a finite number");
  ExpectError("v 0 1,5 0\n", "cloth.obj:1: '1,5' is not a finite number");
  ExpectError("solid scan\nfacet\n",
              "cloth.obj: the file has no faces; no keyword of OBJ: 'facet', 'solid'");
}

TEST_F(ObjIo, NamesTheLineOfABadFace) {
  const std::string square(kSquare);
  ExpectError(square + "f 1 2\n", "cloth.obj:5: the face has 2 corners, expected 3");
  ExpectError(square + "f 1 2 0\n", "cloth.obj:5: corner '0': '0' is not an index");
  ExpectError(square + "f 1 2 x\n", "cloth.obj:5: corner 'x': 'x' is not an index");
  ExpectError(square + "f 1 2 3.0\n", "cloth.obj:5: corner '3.0': '3.0' is not an index");
  ExpectError(square + "f 1 2 3/\n", "cloth.obj:5: corner '3/', expected a, a/b");
  ExpectError(square + "f 1 2 3//\n", "cloth.obj:5: corner '3//': '' is not an index");
  ExpectError(square + "f 1 2 3/1/1/1\n", "cloth.obj:5: corner '3/1/1/1', expected a, a/b");
  ExpectError(square + "f 1 2 5\n", "cloth.obj:5: v index 5, but the file has 4 'v' lines");
  ExpectError(square + "f 1/1 2 3\n", "cloth.obj:5: vt index 1, but the file has 0 'vt' lines");
  ExpectError(square + "f 1//1 2 3\n", "cloth.obj:5: vn index 1, but the file has 0 'vn' lines");
  ExpectError(square + "f 1 2 -5\n", "index -5 precedes the first of 4 entries");
}

TEST_F(ObjIo, PassesOnWhatTheMeshRejects) {
  ExpectError(kSquare, "cloth.obj: the file has no faces");
  ExpectError(std::string(kSquare) + "f 1 2 3\n", "cloth.obj: vertex 4 belongs to no face");
  ExpectError("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "cloth.obj: face 1: UV area is 0 m²");
  EXPECT_INPUT_ERROR(ReadObj(Path("absent.obj")), "absent.obj: no such file");
  EXPECT_INPUT_ERROR(ReadObj(Path("")), "is a folder, expected a file");
}

TEST_F(ObjIo, ReadsASurfaceWithoutMaterialCoordinates) {
  const ObjSurface surface =
      ReadObjSurface(Write("target.obj", "v 0 0 0\nv 1 0 2\nv 0 1 1\nf 1 3 2\n"));
  EXPECT_EQ(surface.x.size(), 9);
  EXPECT_EQ(surface.x[5], 2);
  EXPECT_THAT(surface.triangles, ElementsAre(ElementsAre(0, 2, 1)));
}

TEST_F(ObjIo, ReadsBackWhatItWrote) {
  const Mesh mesh = Parse("v .1 0 0\nv .7 .1 0\nv .3 .9 0\nf 1 2 3\n");
  const Eigen::VectorXd x = mesh.rest_x.array() / 1.3 + 1e-17;
  WriteObj(Path("out.obj"), mesh, x);
  const Mesh again = ReadObj(Path("out.obj"));
  EXPECT_EQ(again.rest_x, x);
  EXPECT_EQ(again.uv, mesh.uv);
  EXPECT_THAT(again.faces[0].vertex, ElementsAre(0, 1, 2));
  WriteObj(Path("surface.obj"), ObjSurface{x, {{2, 1, 0}}});
  const ObjSurface surface = ReadObjSurface(Path("surface.obj"));
  EXPECT_EQ(surface.x, x);
  EXPECT_THAT(surface.triangles, ElementsAre(ElementsAre(2, 1, 0)));
}

TEST_F(ObjIo, TheDiscsOfADrapeAreKept) {
  const Mesh mesh = MakeDisc({.target_vertices = 100});
  WriteObj(Path("a.obj"), mesh, mesh.rest_x, DrapeDiscs{0.12, 0.0635});
  EXPECT_EQ(ReadObjDiscs(Path("a.obj")), (DrapeDiscs{0.12, 0.0635}));
  WriteObj(Path("b.obj"), mesh, mesh.rest_x);
  EXPECT_EQ(ReadObjDiscs(Path("b.obj")), std::nullopt);
  EXPECT_EQ(ReadObj(Path("a.obj")).rest_x, ReadObj(Path("b.obj")).rest_x);
}

TEST(DrapeDiscs, AreALineOfText) {
  EXPECT_EQ(DiscsLine({}), "specimen_diameter_m=0.3 support_diameter_m=0.18");
  EXPECT_EQ(ParseDiscsLine(DiscsLine({0.127, 0.0635})), (DrapeDiscs{0.127, 0.0635}));
  EXPECT_EQ(ToString(DrapeDiscs{0.12, 0.09}), "24 cm on 18 cm");
  for (const char* line : {"", "specimen_diameter_m=0.3", "a comment",
                           "specimen_diameter_m=0.1 support_diameter_m=0.18",
                           "specimen_diameter_m=nan support_diameter_m=0.18"})
    EXPECT_EQ(ParseDiscsLine(line), std::nullopt) << line;
}

}  // namespace
}  // namespace drape
