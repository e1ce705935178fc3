// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/cloth_model.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/cloth/state.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

std::vector<int> HeldVertices(const Mesh& mesh, const Scene& scene) {
  std::vector<int> held;
  if (!scene.handles) return held;
  const auto& [regions, vertices, stiffness] = *scene.handles;
  for (const int i : vertices)
    if (i < 0 || i >= mesh.num_vertices())
      throw InputError("scene", Format("found the handle of vertex %d, expected 0 … %d", i,
                                       mesh.num_vertices() - 1));
  for (int i = 0; i < mesh.num_vertices(); ++i) {
    const Eigen::Vector3d rest = mesh.rest_x.segment<3>(3 * i);
    const bool in_region = std::any_of(regions.begin(), regions.end(), [&](const Region& region) {
      return Contains(region, rest);
    });
    if (in_region || std::find(vertices.begin(), vertices.end(), i) != vertices.end())
      held.push_back(i);
  }
  return held;
}

// Each end of a loaded edge gets half of the force of the edge [MODEL, M28].
std::vector<VertexLoad> LoadedVertices(const Mesh& mesh, const Scene& scene) {
  std::vector<VertexLoad> loads;
  if (!scene.load) return loads;
  Eigen::VectorXd share = Eigen::VectorXd::Zero(mesh.num_vertices());
  const auto rest = [&](int i) -> Eigen::Vector3d { return mesh.rest_x.segment<3>(3 * i); };
  for (const std::vector<int>& loop : mesh.boundary_loops)
    for (std::size_t k = 0; k < loop.size(); ++k) {
      const int a = loop[k], b = loop[(k + 1) % loop.size()];
      if (!Contains(scene.load->region, rest(a)) || !Contains(scene.load->region, rest(b)))
        continue;
      const double half = 0.5 * (rest(a) - rest(b)).norm();
      share[a] += half;
      share[b] += half;
    }
  if (!(share.sum() > 0.0))
    throw InputError("scene",
                     "found no edge of the hem in the region of the load, expected at least one");
  share /= share.sum();
  for (int i = 0; i < mesh.num_vertices(); ++i)
    if (share[i] > 0.0) loads.push_back({i, share[i] * scene.load->force});
  return loads;
}

// A face whose vertices are all held cannot turn: the hinge towards a free face bends over the free
// face alone [MODEL, M26].
void ClampHeldWings(const std::vector<int>& held, Mesh& mesh) {
  std::vector<bool> is_held(mesh.num_vertices());
  for (const int i : held) is_held[i] = true;
  const auto is_fixed = [&](int f) {
    const auto& corners = mesh.faces[f].vertex;
    return std::all_of(std::begin(corners), std::end(corners), [&](int i) { return is_held[i]; });
  };
  for (Hinge& hinge : mesh.hinges) {
    const bool first = is_fixed(hinge.face[0]), second = is_fixed(hinge.face[1]);
    if (first != second) hinge.rest_area = mesh.faces[hinge.face[first ? 1 : 0]].area;
  }
}

}  // namespace

ClothModel::ClothModel(Mesh mesh_in, Scene scene_in, Law law_in)
    : mesh(std::move(mesh_in)),
      scene(std::move(scene_in)),
      law(law_in),
      pattern(MakeBlockPattern(mesh, scene.stretch, scene.bend)),
      vertex_area(Eigen::VectorXd::Zero(mesh.num_vertices())),
      held(HeldVertices(mesh, scene)),
      loads(LoadedVertices(mesh, scene)) {
  if (!law.held_wing_bends()) ClampHeldWings(held, mesh);
  for (const Face& f : mesh.faces)
    for (int i : f.vertex) vertex_area[i] += f.area / 3.0;
}

State ClothModel::RestState() const { return {mesh.rest_x, Eigen::VectorXd::Zero(num_dofs())}; }

Eigen::VectorXd ClothModel::LumpedMass(double density) const {
  Eigen::VectorXd mass(num_dofs());
  for (int i = 0; i < mesh.num_vertices(); ++i)
    mass.segment<3>(3 * i).setConstant(density * vertex_area[i]);
  return mass;
}

bool HasDiscs(const ClothModel& model, const DrapeDiscs& discs) {
  constexpr double kTolerance = 0.02;
  const std::optional<double> support = SupportRadius(model.scene);
  return support && std::abs(*support / discs.support - 1.0) < kTolerance &&
         std::abs(HemRadius(model.mesh) / discs.specimen - 1.0) < kTolerance;
}

void RequireDiscs(const ClothModel& model, const DrapeDiscs& discs, const std::string& mesh) {
  if (!HasDiscs(model, discs))
    throw InputError(mesh, Format("found a cloth of radius %g m, expected %g m, half the diameter "
                                  "of the specimen",
                                  HemRadius(model.mesh), discs.specimen));
}

}  // namespace drape
