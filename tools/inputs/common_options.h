// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/dataset/trivial_predictors.h"
#include "physics/material/laws/law_kind.h"
#include "solver/prediction/generative/generative_prediction.h"
#include "tools/cli/option_table.h"
#include "tools/inputs/scene_input.h"

namespace drape {

// Options that mean the same in several programs.
Option OutOption(std::string& folder);
Option LawOption(std::string& law);  // MakeLaw
Option LawOption(LawKind& law);
Option ThreadsOption(int& threads);  // 0: all cores, which is the default of each program
// The threads as a count. Throws InputError when so many cannot be started (RequireThreads).
int CountThreads(int threads);
int MostThreads();  // that make sense on this machine
// Throws InputError when so many threads cannot run at once, as under a limit of memory, where
// OpenMP would end the program.
void RequireThreads(int threads);
// A fabric of one table (ReadMaterial), or several.
Option FabricOption(Option::Value fabric);
Option TimeStepOption(double& time_step, const std::string& doc = "time step");  // [s]
// A number from `least` to `most`, or several.
Option NumberOption(const std::string& key, Option::Value number, double least, double most,
                    const std::string& doc, const std::string& unit = "");
// A file or a folder, or several.
Option PathOption(const std::string& key, Option::Value path, const std::string& doc);
// A cloth (ParseMeshSpec), or several.
Option MeshOption(const std::string& key, Option::Value mesh, const std::string& doc);

// What names the cloth: mesh, material, law, specimen and support.
std::vector<Option> ClothOptions(SceneInput& scene);
// The same, the first shape, and loads and supports.
std::vector<Option> SceneOptions(SceneInput& scene);
// The pool of drapes from which a fabric is learned, and its further rounds.
std::vector<Option> PoolOptionRows(LearningOptions& learning);
// The data set and its split.
std::vector<Option> DatasetOptions(DatasetQuery& query);
// What sets the camera.
std::vector<Option> CameraOptions(CameraInput& camera);

}  // namespace drape
