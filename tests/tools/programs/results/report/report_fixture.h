// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "physics/mesh/disc.h"
#include "physics/mesh/obj_io.h"
#include "tests/physics/cloth/contact/closed_mesh.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {

inline const std::string kReport = std::string(DRAPE_BIN_DIR) + "/drape_report";

class ReportTest : public ToolFixture {
 protected:
  static constexpr std::array kRises = {0.0f, 0.25f, 0.5f, 0.75f, 1.0f};  // [m]
  std::string AddFit(const std::string& name, const Json& more) const {
    Json summary = {{"start_material", "a<b>.json"}};
    summary.update(more);
    return AddResult(name, "drape_fit", summary);
  }
  std::string AddResult(const std::string& name, const std::string& program, Json summary) const {
    std::filesystem::create_directories(Path(name));
    summary["tool"] = program;
    Write(name + "/summary.json", summary.dump());
    return Path(name);
  }
  // A round cloth above a ball, which rise by a metre in kRises.size() frames.
  std::string AddGarment(const std::string& name, int draws = 1) const {
    const Mesh cloth = MakeDisc({.target_vertices = 200});
    const ClosedMesh ball = MakeBall(0.1, 2);
    const std::string folder = AddResult(
        name, "drape_garment",
        {{"frames_per_second", 5}, {"runs", Json::array_t(draws, Json{{"status", "done"}})}});
    for (int i = 1; i <= draws; ++i) {
      const std::string part = draws == 1 ? "/" : "/draw_" + std::to_string(i) + "/";
      std::filesystem::create_directories(folder + part);
      WriteObj(folder + part + "garment.obj", cloth, cloth.rest_x);
      WriteObj(folder + part + "body.obj", ObjSurface{ball.x.reshaped(), ball.triangles});
      WriteCache(name + part + "garment.pc2", cloth.rest_x);
      WriteCache(name + part + "body.pc2", ball.x.reshaped());
    }
    return folder;
  }
  void WriteCache(const std::string& name, const Eigen::VectorXd& x) const {
    const int32_t numbers[] = {1, static_cast<int32_t>(x.size() / 3), 0, 0x3f800000,
                               static_cast<int32_t>(kRises.size())};
    std::string bytes("POINTCACHE2\0", 12);
    bytes.append(reinterpret_cast<const char*>(numbers), sizeof(numbers));
    for (const float rise : kRises) {
      Eigen::VectorXf frame = x.cast<float>();
      for (Eigen::Index i = 2; i < frame.size(); i += 3) frame[i] += rise;
      bytes.append(reinterpret_cast<const char*>(frame.data()), 4 * frame.size());
    }
    Write(name, bytes);
  }
  // Fields over two triangles with one edge between them.
  static Json SmallFields() {
    return {{"uv_m", {{0, 0}, {0.1, 0}, {0.1, 0.1}, {0, 0.1}}},
            {"faces", {{0, 1, 2}, {0, 2, 3}}},
            {"hinges", Json::array({{0, 2, 1, 0}})},
            {"stretch_n_per_m", {40, 80}},
            {"bend_n_m", Json::array({1.5e-6})},
            {"stretch_uncertainty", {0.25, 0.5}},
            {"bend_uncertainty", Json::array({1})}};
  }
  std::string Page(std::vector<std::string> folders, double max_mb = 2.0) const {
    folders.insert(folders.begin(), kReport);
    folders.push_back("--out=" + Path("page.html"));
    folders.push_back("--max_mb=" + std::to_string(max_mb));
    const ProcessResult result = RunProcess(folders);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    return Read(Path("page.html"));
  }
};

}  // namespace drape::test
