// SPDX-License-Identifier: Apache-2.0
// Writes the built-in disc of so many vertices as an OBJ file, for the Python module.
// usage: write_disc <vertices> <file>
#include <cstdlib>

#include "physics/mesh/disc.h"
#include "physics/mesh/obj_io.h"

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const drape::Mesh mesh = drape::MakeDisc({.target_vertices = std::atoi(argv[1])});
  drape::WriteObj(argv[2], mesh, mesh.rest_x, drape::DrapeDiscs());
  return 0;
}
