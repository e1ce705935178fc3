// SPDX-License-Identifier: Apache-2.0
// Each kind of bad input gives one line on stderr and exit code 2, and loses nothing.
#include <fstream>
#include <functional>

#include "losses/image/image.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

// A square of two triangles; `faces` replaces the second.
std::string Square(const std::string& second_face) {
  return "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\n" + second_face + "\n";
}

std::string Fabric(const std::function<void(nlohmann::json&)>& change) {
  std::ifstream in(kFabric);
  auto fabric = nlohmann::json::parse(in);
  change(fabric);
  return fabric.dump();
}

std::string StartShape(const std::vector<double>& amplitudes) {
  nlohmann::json shape = {{"format", "drapefit-start-shape"}, {"version", 1}};
  for (const double amplitude : amplitudes)
    shape["modes"].push_back({{"k", 2}, {"amplitude_m", amplitude}, {"phase", 0}});
  return shape.dump();
}

// A round silhouette of `radius` px about the centre of a size × size image.
GrayImage Circle(int size, double radius) {
  GrayImage image(size, size);
  for (int row = 0; row < size; ++row)
    for (int column = 0; column < size; ++column)
      image.at(column, row) =
          std::hypot(column - 0.5 * (size - 1), row - 0.5 * (size - 1)) < radius ? 1.0f : 0.0f;
  return image;
}

struct BadInput {
  std::string name;
  std::string option;  // that names the bad file
  std::string file;
  std::function<std::string()> content;
  std::string expected;
};

const BadInput kBadInputs[] = {
    {"TruncatedObj", "mesh", "a.obj", [] { return std::string("v 0 0 0\nv 1 0"); }, "a.obj:2"},
    {"FaceOfTwoCorners", "mesh", "a.obj", [] { return Square("f 1 3"); }, "a.obj:6"},
    {"MillimetreObj", "mesh", "a.obj", [] { return "v 0 0 0\nv 300 0 0\nv 0 300 0\nf 1 2 3\n"; },
     "in mm it would be 0.3 m"},
    {"GramsForKilograms", "fabric", "m.json",
     [] { return Fabric([](auto& f) { f["density"] = 1500; }); }, "in g/m2 it would be 1.5 kg/m2"},
    {"DuplicateFaces", "mesh", "a.obj", [] { return Square("f 1 2 3\nf 1 3 4"); }, "face 2"},
    {"NonManifoldEdge", "mesh", "a.obj", [] { return "v .5 .2 0\n" + Square("f 2 3 5\nf 1 2 3"); },
     "a.obj"},
    {"ZeroAreaTriangle", "mesh", "a.obj", [] { return "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"; },
     "area"},
    {"FewVertices", "mesh", "disc:7", nullptr, "7"},
    {"NanInTable", "fabric", "m.json",
     [] { return Fabric([](auto& f) { f["stretch"][1][2] = "NaN"; }); }, "'stretch[1][2]'"},
    {"BareNanInTable", "fabric", "m.json",
     [] {
       std::string text = Fabric([](auto& f) { f["density"] = 77; });
       return text.replace(text.find("77"), 2, "NaN");
     },
     "m.json"},
    {"NegativeStiffness", "fabric", "m.json",
     [] { return Fabric([](auto& f) { f["bend"][0][3] = -1e-5; }); }, "'bend[0][3]'"},
    {"AbsurdDensity", "fabric", "m.json",
     [] { return Fabric([](auto& f) { f["density"] = 1e308; }); },
     "m.json: key 'density': found 1e+308, expected 1e-05 to 1000 kg/m²"},
    {"AbsurdStretch", "fabric", "m.json",
     [] { return Fabric([](auto& f) { f["stretch"][2][1] = 1e12; }); }, "'stretch[2][1]'"},
    {"AbsurdBend", "fabric", "m.json",
     [] { return Fabric([](auto& f) { f["bend"][2][1] = 1e5; }); }, "'bend[2][1]'"},
    {"AbsurdAmplitude", "start", "s.json",
     [] {
       return StartShape({0.01, 1e308});
     },
     "s.json: key 'modes[1].amplitude_m': found 1e+308, expected a number from -0.1 to 0.1"},
    {"ManyModes", "start", "s.json", [] { return StartShape(std::vector<double>(101, 0.001)); },
     "'modes': found an array of 101, expected at most 100 modes"},
    {"HighModes", "start", "s.json",
     [] {
       return StartShape({0.1, 0.09, 0.08});
     },
     "expected a root mean square height of at most 0.1 m"},
    {"AbsurdGravity", "scene", "g.json",
     [] { return std::string(R"({"gravity": [0, 0, -1e308]})"); }, "'gravity[2]'"},
    {"AbsurdHandles", "scene", "g.json",
     [] { return std::string(R"({"handles": {"vertices": [0], "stiffness": 1e300}})"); },
     "g.json: key 'handles.stiffness': found 1e+300, expected a number > 0 and ≤ 1e+09"},
    {"AbsurdRadius", "mesh", "disc:200,radius=1e100", nullptr, "radius 1e+100 m"},
    {"UnknownMaterialKey", "fabric", "m.json",
     [] { return Fabric([](auto& f) { f["sterch"] = 1; }); }, "'sterch', allowed: "},
    {"StateOfAnotherMesh", "start", "s.json",
     [] { return std::string(R"({"x": [[0,0,0]], "v": [[0,0,0]]})"); }, "120"},
    {"UnknownStart", "start", "s.json", [] { return std::string("{}"); }, "start shape"},
    {"NoImage", "image", "nothing.png", nullptr, "nothing.png: no such file"},
    {"EmptyImage", "image", "a.png", [] { return std::string(); }, "a.png"},
    {"UnknownConfigKey", "config", "c.json", [] { return std::string(R"({"stpes": 3})"); },
     "unknown key 'stpes', allowed: mesh fabric"},
    {"ConfigOfAWrongType", "config", "c.json", [] { return std::string(R"({"steps": "3"})"); },
     "key 'steps': found \"3\", expected a number, 0 … 1000000"},
    {"ConfigOutOfRange", "config", "c.json", [] { return std::string(R"({"time_step": 0})"); },
     "key 'time_step': found 0, expected a number, > 0 and ≤ 10 s"},
    {"ConfigOfAnUnknownChoice", "config", "c.json",
     [] { return std::string(R"({"law": "hooke"})"); }, "expected one of reference, smooth"},
    {"ConfigGivenTwice", "config", "c.json",
     [] { return std::string(R"({"steps": 3, "steps": 4})"); }, "given twice"},
    {"TruncatedConfig", "config", "c.json", [] { return std::string(R"({"steps": )"); }, "c.json"},
};

void PrintTo(const BadInput& bad, std::ostream* out) { *out << bad.name; }

class BadInputTest : public ToolFixture, public testing::WithParamInterface<BadInput> {};
INSTANTIATE_TEST_SUITE_P(Simulate, BadInputTest, testing::ValuesIn(kBadInputs),
                         [](const auto& info) { return info.param.name; });

TEST_P(BadInputTest, IsOneLineAndLosesNothing) {
  ASSERT_EQ(Simulate().exit_code, 0);
  const auto before = Snapshot(Path("out"));
  const BadInput& bad = GetParam();
  const bool is_spec = bad.file.find(':') != std::string::npos;
  const std::string file = is_spec ? bad.file : Path(bad.file);
  if (bad.content) Write(bad.file, bad.content());
  ExpectOneLineError(Simulate({"--" + bad.option + "=" + file}), bad.expected);
  EXPECT_EQ(Snapshot(Path("out")), before);
}

struct BadImage {
  std::string name;
  std::function<void(const std::string&)> write;
  std::string expected;
};

const BadImage kBadImages[] = {
    {"Empty", [](const std::string& path) { std::ofstream(path).close(); }, "bad.png"},
    {"NotAnImage", [](const std::string& path) { std::ofstream(path) << "hello"; }, "bad.png"},
    {"OnePixel", [](const std::string& path) { WritePng(GrayImage(1, 1), path); }, "1"},
    {"AllWhite", [](const std::string& path) { WritePng(GrayImage(256, 256), path); },
     "the picture is of one colour"},
    {"AllBlack", [](const std::string& path) { WritePng(GrayImage(256, 256, 1), path); },
     "bad.png"},
    {"TouchesTheBorder", [](const std::string& path) { WritePng(Circle(256, 130), path); },
     "border"},
    {"NoScale", [](const std::string& path) { WritePng(Circle(300, 100), path); },
     "image is 300x300 px and its scale is not given"},
};

void PrintTo(const BadImage& bad, std::ostream* out) { *out << bad.name; }

class BadImageTest : public ToolFixture, public testing::WithParamInterface<BadImage> {
 protected:
  // An earlier result that no run may touch.
  void SetUp() override {
    std::filesystem::create_directory(Path("out"));
    for (const char* name : {"out/summary.json", "out/material.json", "out/fit.log"})
      Write(name, "earlier");
  }
};
INSTANTIATE_TEST_SUITE_P(Both, BadImageTest, testing::ValuesIn(kBadImages),
                         [](const auto& info) { return info.param.name; });

TEST_P(BadImageTest, IsOneLineAndLosesNothing) {
  const std::string image = Path("bad.png");
  GetParam().write(image);
  const auto before = Snapshot(Path("out"));
  const ProcessResult fit =
      RunProcess({kFit, "--images=" + image, "--fabric=" + kFabric, "--mesh=disc:120",
                  "--coarse_mesh=disc:100", "--out=" + Path("out")});
  ExpectOneLineError(fit, GetParam().expected);
  ExpectOneLineError(Simulate({"--image=" + image}), GetParam().expected);
  EXPECT_EQ(Snapshot(Path("out")), before);
}

class BadOutputTest : public ToolFixture {};

TEST_F(BadOutputTest, AFileInPlaceOfTheFolder) {
  const std::string file = Write("taken", "mine");
  ExpectOneLineError(Simulate({"--out=" + file}), "taken: cannot write to the output folder");
  ExpectOneLineError(Simulate({"--out=" + file + "/below"}), "Not a directory");
  EXPECT_EQ(Read(file), "mine");
  ExpectOneLineError(Simulate({"--out=/proc/drapefit"}), "/proc/drapefit");
}

// A limit on the file size is what a full disk looks like without root. The first file of the
// second run fits, the next does not: neither may replace one of the first run.
TEST_F(BadOutputTest, AFullDiskKeepsTheEarlierResult) {
  if (!kCanLimitFiles) GTEST_SKIP() << "LLVM's OpenMP needs a file";
  ASSERT_EQ(Simulate({"--dump_steps=0,1"}).exit_code, 0);
  const auto before = Snapshot(Path("out"));
  const long one_file = static_cast<long>(Read(Path("out/state_0.json")).size()) + 500;
  const ProcessResult result =
      Simulate({"--dump_steps=0,1", "--mesh=disc:121"}, {.file_bytes = one_file});
  ExpectOneLineError(result, "state_1.json: cannot write the whole file");
  EXPECT_EQ(Snapshot(Path("out")), before);
  ExpectOneLineError(Simulate({"--out=" + Path("new/one")}, {.file_bytes = 1000}), "cannot write");
  EXPECT_FALSE(std::filesystem::exists(Path("new/one")));
}

// Images that cannot be fitted together, or not at all.
TEST_F(BadOutputTest, FitChecksItsInputFirst) {
  WritePng(Circle(256, 104), Path("a.png"));
  const auto fit = [&](std::vector<std::string> more) {
    std::vector<std::string> command = {kFit, "--images=" + Path("a.png"), "--fabric=" + kFabric,
                                        "--mesh=disc:120", "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command);
  };
  ExpectOneLineError(fit({"--images=" + Path("*.jpg")}), "matches nothing");
  ExpectOneLineError(fit({"--images=" + Path("a.png") + "," + Path("a.png")}), "distinct names");
  ExpectOneLineError(fit({"--candidates_per_round=4,2"}),
                     "as many rounds as 'candidates_per_round' has");
  ExpectOneLineError(fit({"--candidates_per_round="}), "option 'candidates_per_round'");
  ExpectOneLineError(fit({"--model=garment"}), "expected one of homo");
  ExpectOneLineError(fit({"--fabric=" + Path("none.json")}), "none.json: no such file");
  EXPECT_FALSE(std::filesystem::exists(Path("out/summary.json")));
}

}  // namespace
}  // namespace drape::test
