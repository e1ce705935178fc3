// SPDX-License-Identifier: Apache-2.0
// drape_simulate --geometry, opened by the programs that read it.
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

class GeometryFiles : public ToolFixture {
 protected:
  static bool Runs(const std::string& command) {
    return RunProcess({"/bin/sh", "-c", command}).exit_code == 0;
  }
};

TEST_F(GeometryFiles, AreWrittenWithTheDrape) {
  ASSERT_EQ(Simulate({"--geometry=vtu", "--dump_steps=1,3"}).exit_code, 0);
  for (const char* name : {"drape.vtu", "drape.pvd", "state_1.vtu", "state_3.vtu"})
    EXPECT_TRUE(std::filesystem::exists(Path("out/") + name)) << name;
  EXPECT_THAT(Read(Path("out/drape.pvd")), testing::HasSubstr("state_3.vtu"));
  ExpectOneLineError(Simulate({"--geometry=fbx"}), "found 'fbx', expected one of vtu");
}

TEST_F(GeometryFiles, VtuIsReadByMeshio) {
  std::string python;
  for (const char* candidate : {"/usr/bin/python3", "python3"})
    if (Runs(std::string(candidate) + " -c 'import meshio'")) python = candidate;
  if (python.empty()) GTEST_SKIP() << "needs python3-meshio";
  ASSERT_EQ(Simulate({"--geometry=vtu"}).exit_code, 0);
  Write("read.py", R"py(
import sys
import meshio
drape = meshio.read(sys.argv[1] + "/drape.vtu")
points = [[float(c) for c in l.split()[1:]] for l in open(sys.argv[1] + "/drape.obj") if l.startswith("v ")]
assert drape.points.tolist() == points
faces = len(drape.cells[0].data)
assert drape.cells[0].type == "triangle"
assert drape.cell_data["strain [1]"][0].shape == (faces, 3)
assert drape.cell_data["stiffness [N/m]"][0].shape == (faces, 4)
print("EQUAL")
)py");
  const ProcessResult run =
      RunProcess({"/bin/sh", "-c", python + " '" + Path("read.py") + "' '" + Path("out") + "'"});
  EXPECT_EQ(run.out, "EQUAL\n") << run.err;
}

}  // namespace
}  // namespace drape::test
