// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "cuda/kernels/cloth/mesh_view.h"
#include "physics/mesh/mesh.h"

namespace drape::test {

// A mesh as kernels see it, in the mesh's own order; `mesh` outlives the object.
class MeshOnHost {
 public:
  explicit MeshOnHost(const Mesh& mesh) : mesh_(mesh), border_(FindBorder(mesh)) {}
  MeshView view() const {
    return MakeView(mesh_, mesh_.faces.data(), mesh_.hinges.data(), border_.data());
  }

 private:
  const Mesh& mesh_;
  std::vector<int> border_;
};

}  // namespace drape::test
