// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "cuda/mesh_view.h"
#include "physics/mesh.h"

namespace drape::test {

// A mesh as kernels see it, in the mesh's own order; `mesh` outlives the object.
class MeshOnHost {
 public:
  explicit MeshOnHost(const Mesh& mesh) : mesh_(mesh), border_(BorderOf(mesh)) {}
  MeshView view() const {
    return ViewOf(mesh_, mesh_.faces.data(), mesh_.hinges.data(), border_.data());
  }

 private:
  const Mesh& mesh_;
  std::vector<int> border_;
};

}  // namespace drape::test
