// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/inputs/files/file_readers.h"

#include "tests/attack/inputs/valid_inputs.h"

namespace drape::attack {
namespace {

void AddJson(const std::string& valid_text, std::vector<FileReader>* readers) {
  for (const BadFile& bad : MakeBadJson(valid_text)) readers->back().bad.push_back(bad);
}

std::vector<std::string> WithOption(const std::string& program, const std::string& option) {
  return QuickCommand(program, {option});
}

void AddMaterials(const std::string& valid, std::vector<FileReader>* readers) {
  readers->push_back({.name = "material",
                      .file = "in/material.json",
                      .commands = {WithOption("drape_simulate", "--fabric=in/material.json"),
                                   WithOption("drape_check", "--fabric=in/material.json"),
                                   WithOption("drape_equilibria", "--fabric=in/material.json")},
                      .bad = MakeBadMaterials(valid)});
  AddJson(ReadText(valid + "wool.json"), readers);
  readers->push_back({.name = "field",
                      .file = "in/field.json",
                      .commands = {WithOption("drape_simulate", "--fabric=in/field.json")},
                      .bad = MakeBadFields(valid)});
  readers->push_back({.name = "posterior",
                      .file = "in/posterior.json",
                      .commands = {WithOption("drape_predict", "--fabric=in")},
                      .beside = {"posterior/base.json"},
                      .bad = MakeBadPosteriors(valid)});
  AddJson(ReadText(valid + "posterior/posterior.json"), readers);
  readers->push_back(
      {.name = "lab test",
       .file = "in/test.json",
       .commands = {WithoutOption(WithOption("drape_fit", "--lab_tests=in/test.json"), "--images")},
       .bad = MakeBadLabTests(valid)});
  AddJson(ReadText(valid + "tensile.json"), readers);
}

void AddShapes(const std::string& valid, std::vector<FileReader>* readers) {
  readers->push_back({.name = "mesh",
                      .file = "in/mesh.obj",
                      .commands = {WithOption("drape_simulate", "--mesh=in/mesh.obj"),
                                   WithOption("drape_check", "--mesh=in/mesh.obj")},
                      .bad = MakeBadMeshes()});
  readers->push_back({.name = "start",
                      .file = "in/start.json",
                      .commands = {WithOption("drape_simulate", "--start=in/start.json"),
                                   WithOption("drape_stability", "--start=in/start.json"),
                                   WithOption("drape_bench", "--start=in/start.json")},
                      .bad = MakeBadStarts(valid)});
  AddJson(ReadText(valid + "waves.json"), readers);
  readers->push_back({.name = "state",
                      .file = "in/state.json",
                      .commands = {WithOption("drape_simulate", "--start=in/state.json"),
                                   WithOption("drape_check", "--start=in/state.json")},
                      .bad = MakeBadStates(valid)});
  readers->push_back(
      {.name = "scene",
       .file = "in/scene.json",
       .commands = {WithOption("drape_simulate", "--scene=in/scene.json"),
                    QuickCommand("drape_simulate", {"--scene=in/scene.json", "--start=flat",
                                                    "--mesh=strip:0.2x0.05x10"})},
       .bad = MakeBadScenes(valid)});
  AddJson(ReadText(valid + "scene.json"), readers);
}

void AddSettings(const std::string& valid, std::vector<FileReader>* readers) {
  readers->push_back(
      {.name = "config", .file = "in/config.json", .commands = {}, .bad = MakeBadConfigs()});
  for (const std::string& program : ProgramNames())
    readers->back().commands.push_back(WithOption(program, "--config=in/config.json"));
  readers->push_back({.name = "summary as config",
                      .file = "in/summary.json",
                      .commands = {{"drape_simulate", "--config=in/summary.json", "--out=out"}},
                      .bad = MakeBadSummaries(valid)});
  const std::string data = "--data=" + std::string(kValid) + "set";
  readers->push_back({.name = "split",
                      .file = "in/split.json",
                      .commands = {{"drape_metrics", data, "--split=in/split.json"},
                                   QuickCommand("drape_predict", {data, "--split=in/split.json"})},
                      .bad = MakeBadSplits(valid)});
  AddJson(ReadText(valid + "split.json"), readers);
  const std::vector<std::string> accuracy = {"--accuracy=fast", "--accuracy_table=in/table.json"};
  readers->push_back(
      {.name = "accuracy",
       .file = "in/table.json",
       .commands = {{"drape_simulate", "--fabric=" + std::string(kValid) + "wool.json",
                     "--start=" + std::string(kValid) + "waves.json", "--out=out", accuracy[0],
                     accuracy[1]}},
       .bad = MakeBadAccuracyTables(valid)});
  AddJson(ReadText(valid + "accuracy.json"), readers);
}

void AddSpaces(const std::string& valid, std::vector<FileReader>* readers) {
  const std::string others = std::string(kValid) + "posterior_2," + kValid + "posterior_3";
  readers->push_back({.name = "posterior of a fabric",
                      .file = "in/posterior.json",
                      .commands = {WithOption("drape_space", "--posteriors=in," + others),
                                   WithOption("drape_space", "--new=in")},
                      .beside = {"posterior/base.json"},
                      .bad = MakeBadPosteriors(valid)});
  readers->push_back(
      {.name = "space",
       .file = "in/space.json",
       .commands = {QuickCommand(
           "drape_fit", {"--model=bayes", "--posterior_iterations=1", "--posterior_samples=2",
                         "--elbo_samples=25", "--prior=in/space.json"})},
       .bad = MakeBadSpaces(valid)});
  AddJson(ReadText(valid + "space.json"), readers);
}

void AddGarments(const std::string& valid, std::vector<FileReader>* readers) {
  readers->push_back({.name = "garment",
                      .file = "in/garment.json",
                      .commands = {WithOption("drape_garment", "--garment=in/garment.json")},
                      .bad = MakeBadGarments(valid)});
  AddJson(ReadText(valid + "skirt.json"), readers);
  readers->push_back({.name = "GarmentCode",
                      .file = "in/specification.json",
                      .commands = {WithOption("drape_garment", "--garment=in/specification.json")},
                      .bad = MakeBadGarmentCodes(valid)});
  readers->push_back({.name = "body",
                      .file = "in/body_0000.obj",
                      .commands = {WithOption("drape_garment", "--body=in/body_%04d.obj")},
                      .bad = MakeBadBodies(valid)});
  readers->push_back(
      {.name = "contact",
       .file = "in/contact.json",
       .commands = {QuickCommand("drape_simulate", {"--scene=in/contact.json", "--start=flat"})},
       .bad = MakeBadContacts(valid)});
}

}  // namespace

std::vector<FileReader> MakeFileReaders(const std::string& valid) {
  std::vector<FileReader> readers;
  AddMaterials(valid, &readers);
  AddShapes(valid, &readers);
  AddSettings(valid, &readers);
  AddSpaces(valid, &readers);
  AddGarments(valid, &readers);
  for (FileReader& reader : readers) {
    for (BadFile& bad : reader.bad)
      if (bad.named.empty() && bad.refused)
        bad.named = reader.file.substr(reader.file.rfind('/') + 1);
  }
  return readers;
}

}  // namespace drape::attack
