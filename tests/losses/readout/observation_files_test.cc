// SPDX-License-Identifier: Apache-2.0
#include "losses/readout/observation_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cstdlib>
#include <numeric>

#include "tests/losses/disc.h"
#include "tests/losses/image/encode.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

class ObservationFilesTest : public FileFixture {
 protected:
  std::string WritePng(const std::string& name, const void* pixels, int width, int height,
                       png_uint_32 format) const {
    const std::vector<uint8_t> bytes = EncodePng(pixels, width, height, format);
    return Write(name, {bytes.begin(), bytes.end()});
  }
  // Runs Python where it has the modules; returns whether it has.
  bool Python(const std::string& modules, const std::string& script) const {
    const std::string python = "/usr/bin/python3 ";
    if (std::system((python + "-c 'import " + modules + "' 2>/dev/null").c_str()) != 0)
      return false;
    const std::string path = Write("script.py", "import " + modules + "\n" + script);
    EXPECT_EQ(std::system(("cd '" + Path("") + "' && " + python + path + " >/dev/null").c_str()),
              0);
    return true;
  }
};

TEST_F(ObservationFilesTest, ReadsMarkersByMaterialPoint) {
  const std::string comma =
      Write("a.csv", "weft_m,warp_m,x_m,y_m,z_m\n0,0,0.1,0.2,0.3\n1e-2,-0.02,-1,2,3.5\n");
  // As a spreadsheet in German on Windows writes it.
  const std::string semicolon =
      Write("b.csv",
            "\xEF\xBB\xBF\"weft_m\";\"warp_m\";\"x_m\";\"y_m\";\"z_m\"\r\n"
            "0;0;0,1;0,2;0,3\r\n\r\n\"0,01\"; -0,02;-1;2;3,5");
  for (const std::string& path : {comma, semicolon}) {
    const MeasuredMarkers markers = ReadMarkers(path);
    EXPECT_TRUE(markers.vertices.empty());
    EXPECT_EQ(markers.material, (Eigen::Matrix2d() << 0, 0.01, 0, -0.02).finished());
    EXPECT_EQ(markers.x, (Eigen::VectorXd(6) << 0.1, 0.2, 0.3, -1, 2, 3.5).finished());
  }
}

TEST_F(ObservationFilesTest, ReadsMarkersByVertex) {
  const MeasuredMarkers markers =
      ReadMarkers(Write("a.csv", "vertex,x_m,y_m,z_m\n7,0.1,0.2,0.3\n0,0,0,0\n"));
  EXPECT_EQ(markers.vertices, (std::vector<int>{7, 0}));
  EXPECT_EQ(markers.material.size(), 0);
  const Mesh mesh = MakeDisc(1, 8, 0.1);
  const PlaceWeights weights = WeightsOfMarkers(mesh, markers, "a.csv");
  EXPECT_EQ(weights.coeff(0, 7), 1.0);
  EXPECT_INPUT_ERROR(WeightsOfMarkers(MakeDisc(1, 6, 0.1), markers, "a.csv"), "vertex 7");
}

TEST_F(ObservationFilesTest, SaysWhatIsWrongInATable) {
  const auto expect = [&](const std::string& content, const std::string& text) {
    EXPECT_INPUT_ERROR(ReadMarkers(Write("m.csv", content)), text);
  };
  const std::string header = "vertex,x_m,y_m,z_m\n";
  expect("", "m.csv: the file is empty, expected the header 'weft_m,");
  expect("x,y\n1,2\n", "m.csv:1: found 'x,y', expected the header 'weft_m,warp_m,x_m,y_m,z_m' or");
  expect("0,0.1,0.2,0.3\n", "m.csv:1: found '0,0.1,0.2,0.3'");
  expect(header, "m.csv: found a header alone");
  expect(header + "1,2,3\n", "m.csv:2: found 3 fields, expected the 4 of the header");
  expect(header + "\n1,2,x,4\n", "m.csv:3: y_m: found 'x', expected a number");
  expect(header + "1,2,,4\n", "m.csv:2: y_m: found '', expected a number");
  expect(header + "1,2,nan,4\n", "y_m: found 'nan'");
  expect(header + "1,2,3 4,4\n", "y_m: found '3 4'");
  expect(header + "1.5,2,3,4\n", "row 1: vertex: found 1.5, expected a whole number from 0");
  expect(header + "-1,2,3,4\n", "vertex: found -1");
  expect(header + "1,0,0,0\n2,300,0,0\n", "in mm it would be 0.3 m");
  expect(header + "1,\xFF,0,0\n", "x_m: found '\\xff'");
  EXPECT_INPUT_ERROR(ReadMarkers(Path("none.csv")), "none.csv");
}

// A header in one field has the names of a good one and fewer columns.
TEST_F(ObservationFilesTest, RefusesAHeaderOfFewerColumns) {
  EXPECT_INPUT_ERROR(ReadMarkers(Write("a.csv", ";weft_m,warp_m,x_m,y_m,z_m\n0,;0\n")),
                     "a.csv:1: found ';weft_m,warp_m,x_m,y_m,z_m', expected the header");
  EXPECT_INPUT_ERROR(ReadPointCloud(Write("b.csv", ";x,y,z\n0;0\n")), "b.csv:1: found ';x,y,z'");
}

TEST_F(ObservationFilesTest, ReadsCloudsOfPoints) {
  const Eigen::VectorXd points = (Eigen::VectorXd(6) << 0, 0.25, -0.5, 0.125, 1, 2).finished();
  const std::string header = "ply\nformat ascii 1.0\nelement vertex 2\n";
  for (const std::string& path :
       {Write("a.csv", "x,y,z\n0,0.25,-0.5\n0.125,1,2\n"),
        Write("b.txt", "x_m;y_m;z_m\n0;0,25;-0,5\n0,125;1;2\n"),
        Write("c.obj", "v 0 0.25 -0.5\nv 0.125 1 2\n"),
        Write("d.ply", header + "property float x\nproperty float y\nproperty float z\n"
                                "property uchar red\nend_header\n0 0.25 -0.5 9\n.125 1 2 9\n")})
    EXPECT_EQ(ReadPointCloud(path), points) << path;
  EXPECT_INPUT_ERROR(ReadPointCloud(Write("e.csv", "x,y\n1,2\n")), "e.csv:1: found 'x,y'");
  EXPECT_INPUT_ERROR(ReadPointCloud(Write("f.obj", "# nothing\n")), "has no vertices");
  EXPECT_INPUT_ERROR(
      ReadPointCloud(Write("g.ply", header + "property float x\nproperty float y\nend_header\n")),
      "g.ply: the element vertex has no z, expected x, y and z");
  EXPECT_INPUT_ERROR(ReadPointCloud(Write("h.csv", "x,y,z\n0,0,0\n310,20,40\n")), "in mm");
  std::string outlier = "x,y,z\n400,0,0\n";
  for (int i = 0; i < 10; ++i) outlier += "0.1,0.2,0." + std::to_string(i) + "\n";
  EXPECT_EQ(ReadPointCloud(Write("i.csv", outlier)).size(), 33);
}

// Every count is read as it is stored, whatever gamma the file states.
TEST_F(ObservationFilesTest, ReadsTheCountsOfADepthMap) {
  std::vector<uint16_t> counts(65536);
  std::iota(counts.begin(), counts.end(), 0);
  std::string png;
  {
    const std::string path = WritePng("a.png", counts.data(), 256, 256, PNG_FORMAT_LINEAR_Y);
    png = Read(path);
  }
  // A chunk gAMA of 1/2.2 after the header.
  const std::string gamma("\0\0\0\4gAMA\0\0\xb1\x8f\x0b\xfc\x61\x05", 16);
  const std::string plain = Write("plain.png", png);
  const std::string other = Write("gamma.png", png.substr(0, 33) + gamma + png.substr(33));
  for (const std::string& path : {plain, other}) {
    const DepthMap map = ReadDepthMap(path, 0.001);
    ASSERT_EQ(map.width, 256);
    ASSERT_EQ(map.height, 256);
    ASSERT_EQ(map.pixels.size(), 65535u);
    EXPECT_EQ(map.pixels[0], 1);
    for (int i = 0; i < 65536; ++i) ASSERT_EQ(map.depth[i], 0.001 * i) << path;
  }
}

TEST_F(ObservationFilesTest, SaysWhatIsWrongInADepthMap) {
  const std::vector<uint16_t> counts(24, 700), zeros(24, 0);
  const std::string good = WritePng("good.png", counts.data(), 6, 4, PNG_FORMAT_LINEAR_Y);
  EXPECT_INPUT_ERROR(ReadDepthMap(good, 0.0), "metres_per_count: found 0");
  EXPECT_INPUT_ERROR(ReadDepthMap(good, std::nan("")), "metres_per_count");
  EXPECT_INPUT_ERROR(ReadDepthMap(Write("a.png", "GIF89a"), 1e-3), "a.png: is no PNG");
  std::string huge = Read(good);
  huge.replace(16, 8, "\xff\xff\xff\xfc\xff\xff\xf9\x02");
  EXPECT_INPUT_ERROR(ReadDepthMap(Write("huge.png", huge), 1e-3),
                     "image is 4294967292x4294965506, expected at most 2^24 pixels");
  EXPECT_INPUT_ERROR(ReadDepthMap(WritePng("b.png", counts.data(), 6, 4, PNG_FORMAT_GRAY), 1e-3),
                     "b.png: has 8 bits a sample");
  EXPECT_INPUT_ERROR(
      ReadDepthMap(WritePng("c.png", counts.data(), 2, 4, PNG_FORMAT_LINEAR_RGB), 1e-3),
      "colour type 2");
  EXPECT_INPUT_ERROR(ReadDepthMap(WritePng("d.png", zeros.data(), 6, 4, PNG_FORMAT_LINEAR_Y), 1e-3),
                     "d.png: all counts are 0");
  const std::string bytes = Read(good);
  for (const size_t length : {size_t(34), size_t(50), bytes.size() - 20})
    EXPECT_INPUT_ERROR(ReadDepthMap(Write("e.png", bytes.substr(0, length)), 1e-3), "e.png: ");
  std::string large = bytes;
  large.replace(16, 8, std::string("\0\1\0\0\0\1\0\0", 8));
  EXPECT_INPUT_ERROR(ReadDepthMap(Write("f.png", large), 1e-3), "65536x65536, expected at most");
}

TEST_F(ObservationFilesTest, ReadsTheDepthMapOfAnotherProgram) {
  if (!Python("numpy, PIL.Image",
              "a = numpy.arange(12, dtype=numpy.uint16).reshape(3, 4) * 5000\n"
              "PIL.Image.fromarray(a).save('depth.png')\n"))
    GTEST_SKIP() << "no Python with numpy and PIL";
  const DepthMap map = ReadDepthMap(Path("depth.png"), 2e-5);
  ASSERT_EQ(map.width, 4);
  ASSERT_EQ(map.height, 3);
  for (int i = 0; i < 12; ++i) EXPECT_EQ(map.depth[i], 2e-5 * (5000 * i));
}

TEST_F(ObservationFilesTest, ReadsTheCloudsOfAnotherProgram) {
  if (!Python("numpy, meshio",
              "x = numpy.array([[0, .25, -.5], [.125, 1, 2], [.5, .75, 1.5]])\n"
              "mesh = meshio.Mesh(x, [('triangle', [[0, 1, 2]])])\n"
              "mesh.write('text.ply', binary=False)\n"
              "mesh.write('binary.ply', binary=True)\n"
              "mesh.write('mesh.obj')\n"
              "numpy.savetxt('table.csv', x, delimiter=',', header='x,y,z', comments='')\n"))
    GTEST_SKIP() << "no Python with numpy and meshio";
  const Eigen::VectorXd x =
      (Eigen::VectorXd(9) << 0, 0.25, -0.5, 0.125, 1, 2, 0.5, 0.75, 1.5).finished();
  for (const char* name : {"text.ply", "binary.ply", "mesh.obj", "table.csv"})
    EXPECT_EQ(ReadPointCloud(Path(name)), x) << name;
}

}  // namespace
}  // namespace drape
