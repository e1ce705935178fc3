// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "physics/simulation/backend.h"
#include "physics/util/run_control.h"
#include "solver/prediction/generative/generative_prediction.h"
#include "tools/cli/option_table.h"
#include "tools/inputs/scene_input.h"

namespace drape {

// Options that mean the same in several programs.
Option OutOption(std::string& folder);
Option ThreadsOption(int& threads);  // 0: all cores, which is the default of each program
// The threads as a count. Throws InputError when so many cannot be started (RequireThreads).
int CountThreads(int threads);
int MostThreads();  // that make sense on this machine
// Throws InputError when so many threads cannot run at once, as under a limit of memory, where
// OpenMP would end the program.
void RequireThreads(int threads);
// A fabric of one table (ReadMaterial), or several.
Option FabricOption(Option::Value fabric);
// A switch, a text, or several texts.
Option PlainOption(const std::string& key, Option::Value value, const std::string& doc);
// A text that is one of the choices, or several.
Option ChoiceOption(const std::string& key, Option::Value text,
                    const std::vector<std::string>& choices, const std::string& doc);
inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();
// A number from `least` to `most`, or several.
Option NumberOption(const std::string& key, Option::Value number, double least, double most,
                    const std::string& doc, const std::string& unit = "");
// A number above 0, up to `most`, or several.
Option PositiveOption(const std::string& key, Option::Value number, double most,
                      const std::string& doc, const std::string& unit = "");
// The option with the range of most users' values (Field::usual_least).
Option Usual(Option option, double least, double most);
// A time step [s], or several.
Option TimeStepOption(Option::Value time_step, const std::string& doc = "time step");
// A file or a folder, or several.
Option PathOption(const std::string& key, Option::Value path, const std::string& doc);
// A cloth (ParseMeshSpec), or several.
Option MeshOption(const std::string& key, Option::Value mesh, const std::string& doc);

// The options of a scene that name its cloth, without first shape, loads and supports.
std::vector<Option> ClothOptions(SceneInput& scene);
// The pool of drapes from which a fabric is learned, and its further rounds.
std::vector<Option> PoolOptionRows(LearningOptions& learning);

// --backend of each program that runs rollouts.
Option BackendOption(std::string& backend);
// MakeBackend; one line of the log names what it runs on.
std::unique_ptr<Backend> MakeLoggedBackend(const std::string& name,
                                           std::shared_ptr<const ClothModel> model, int threads,
                                           const RunControl& control);

}  // namespace drape
