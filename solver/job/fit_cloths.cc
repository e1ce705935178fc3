// SPDX-License-Identifier: Apache-2.0
#include "solver/job/fit_cloths.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "cuda/make_backend.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

// The search mesh by default: a branch that is found on a coarser one is often lost.
constexpr char kPooledSearchMesh[] = "disc:1200";

FitInput::Cloth MakeCloth(const FitSpec& spec, const DrapeDiscs& discs, const std::string& mesh,
                          SharedBackends::Member* shared, std::string* device) {
  FitInput::Cloth cloth;
  cloth.model = std::make_shared<const ClothModel>(
      ParseMeshSpec(mesh, {}, discs), CusickScene(spec.contact, discs.support), MakeLaw(spec.law));
  if (cloth.model->held.size() == static_cast<size_t>(cloth.model->mesh.num_vertices()))
    throw InputError(mesh,
                     Format("found all vertices on the support of radius %g m, expected a cloth "
                            "that hangs over it",
                            discs.support));
  RequireDiscs(*cloth.model, discs, mesh);
  RequireThinCloth(*cloth.model);
  const auto make = [&] { return MakeBackend(spec.backend, cloth.model, spec.threads, device); };
  const auto key = [&] {
    return Format("%s %.17g %.17g", mesh.c_str(), discs.specimen, discs.support);
  };
  cloth.backend = shared == nullptr ? make() : shared->Share(key(), make);
  if (device != nullptr && device->empty()) *device = cloth.backend->name();
  return cloth;
}

}  // namespace

std::vector<std::string> SearchMeshes(const FitSpec& spec, const DrapeDiscs& discs,
                                      std::vector<std::string>* notes) {
  constexpr double kCoarser = 0.7;  // of the vertices
  constexpr double kMostGrowth = 2.0;
  constexpr double kRounding = 0.1;  // a disc has not exactly the vertices that it is named by
  constexpr std::string_view kDisc = "disc:";
  const Mesh search = ParseMeshSpec(spec.search_mesh, {}, discs),
             fine = ParseMeshSpec(spec.mesh, {}, discs);
  const double growth = double(fine.num_vertices()) / search.num_vertices();
  if (growth * kCoarser < 1.0) return {};
  if (!IsSameCloth(search, fine)) {
    notes->push_back("search_mesh " + spec.search_mesh + " is another cloth than " + spec.mesh +
                     ": the fit is on one mesh, without an estimate of its mesh error");
    return {};
  }
  std::vector<std::string> meshes = {spec.search_mesh};
  const bool are_discs = spec.search_mesh.starts_with(kDisc) && spec.mesh.starts_with(kDisc);
  const int steps =
      are_discs ? int(std::ceil(std::log(growth) / std::log(kMostGrowth) - kRounding)) : 1;
  // The options of a disc, its radius and support, are those of the last one.
  const std::string options = spec.mesh.substr(std::min(spec.mesh.find(','), spec.mesh.size()));
  for (int i = 1; i < steps; ++i)
    meshes.push_back(
        std::string(kDisc) +
        std::to_string(std::lround(search.num_vertices() * std::pow(growth, double(i) / steps))) +
        options);
  return meshes;
}

void MakeCloths(const FitSpec& spec, SharedBackends::Member* shared, FitInput* input) {
  input->fine = MakeCloth(spec, input->discs, spec.mesh, shared, &input->device);
  input->coarse = MakeCloth(spec, input->discs, spec.coarse_mesh, shared, nullptr);
  input->problem.fine = input->fine.backend.get();
  input->problem.coarse = input->coarse.backend.get();
  FitSpec searched = spec;
  if (input->problem.is_pooled && spec.search_mesh == FitSpec().search_mesh)
    searched.search_mesh = kPooledSearchMesh;
  for (const std::string& mesh : SearchMeshes(searched, input->discs, &input->notes)) {
    input->search.push_back(MakeCloth(spec, input->discs, mesh, shared, nullptr));
    input->problem.search.push_back(input->search.back().backend.get());
  }
}

}  // namespace drape
