// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace drape::attack {

// Good inputs of every kind, and a quick good command of every program: each attack changes one
// thing of one of them.

// The folder of the inputs as the programs see it from a sandbox.
inline constexpr char kValid[] = "../../valid/";

// Makes the inputs in <work>/valid; `sources` is the root of the repository.
void MakeValidInputs(const std::string& work, const std::string& sources);

// A summary of drape_simulate as far as a repetition reads it, of a run with the fabric wool.json
// of the folder `valid`, which it names as one in the folder `seen`.
std::string MakeSummary(const std::string& valid, const std::string& seen);

// OBJ of a convex body 1.8 m high, with a ring of vertices in the middle: the pelvis; at x [m].
std::string MakeBodyObj(double x);

// All programs, in the order of the README.
const std::vector<std::string>& ProgramNames();

// A command that takes well under a second and writes to "out"; the program is without folder.
std::vector<std::string> QuickCommand(const std::string& program);

// The same with more options, which come last and win.
std::vector<std::string> QuickCommand(const std::string& program,
                                      const std::vector<std::string>& more);

// Without an option: "--images".
std::vector<std::string> WithoutOption(std::vector<std::string> command, const std::string& flag);

}  // namespace drape::attack
