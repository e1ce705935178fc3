// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

namespace drape {

// Positions [m] and velocities [m/s] of a cloth, node-major, shape [3V] each.
struct State {
  Eigen::VectorXd x;
  Eigen::VectorXd v;
};

// Reads a state file {"x": [[x, y, z], …], "v": [[x, y, z], …]} with one triple for each vertex, in
// m and m/s. Throws InputError, naming the file, the key and the index, for a syntax error, a
// missing or unknown key, a count other than num_vertices, a triple of another length, and a number
// that is not finite.
State ReadState(const std::string& path, int num_vertices);

// Writes a state file atomically. Numbers read back bit for bit. CHECKs equal sizes. Throws
// InputError when the file cannot be written, std::domain_error for a number that is not finite.
void WriteState(const std::string& path, const State& state);

}  // namespace drape
