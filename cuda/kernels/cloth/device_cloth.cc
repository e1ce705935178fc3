// SPDX-License-Identifier: Apache-2.0
#include "cuda/kernels/cloth/device_cloth.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <span>
#include <utility>
#include <variant>

#include "physics/cloth/contact/obstacles/surface_obstacle.h"

namespace drape {
namespace {

int BlockAt(const BlockPattern& pattern, int i, int j) {
  const auto row = pattern.column.begin() + pattern.row_start[i];
  const auto end = pattern.column.begin() + pattern.row_start[i + 1];
  return static_cast<int>(std::lower_bound(row, end, j) - pattern.column.begin());
}

// Block (j, i) of each block (i, j).
std::vector<int> MirrorBlocks(const BlockPattern& pattern) {
  std::vector<int> mirror(pattern.num_blocks());
  for (int i = 0; i < pattern.num_vertices(); ++i)
    for (int b = pattern.row_start[i]; b < pattern.row_start[i + 1]; ++b)
      mirror[b] = BlockAt(pattern, pattern.column[b], i);
  return mirror;
}

std::vector<int> BlocksOfEntries(const BlockPattern& pattern, const FrontPlan& plan) {
  std::vector<int> blocks;
  for (const FrontEntry& entry : plan.entries)
    blocks.push_back(BlockAt(pattern, entry.row, entry.column));
  return blocks;
}

std::vector<double> HandleStiffness(const ClothModel& model, const std::vector<int>& position) {
  std::vector<double> handle(position.size());
  for (int i : model.held) handle[position[i]] = model.scene.handles->stiffness;
  return handle;
}

std::vector<double> Loads(const ClothModel& model, const std::vector<int>& position) {
  std::vector<double> load(3 * position.size());
  for (const VertexLoad& l : model.loads)
    for (int k = 0; k < 3; ++k) load[3 * position[l.vertex] + k] = l.force[k];
  return load;
}

std::vector<double> Areas(const ClothModel& model, const std::vector<int>& position) {
  std::vector<double> area(position.size());
  for (std::size_t i = 0; i < position.size(); ++i) area[position[i]] = model.vertex_area[i];
  return area;
}

Law OnDevice(Law law, DeviceArrays& arrays) {
  if (const auto* reference = std::get_if<ReferenceStretch>(&law.stretch)) {
    constexpr int kNodes = kStrainNodes * kStrainNodes * kStrainNodes;
    law.stretch = ReferenceStretch(arrays.Upload(std::span(reference->nodes(), kNodes)));
  }
  return law;
}

GatherView OnDevice(const GatherList& list, DeviceArrays& arrays) {
  return {arrays.Upload(list.start), arrays.Upload(list.item)};
}

SurfaceView OnDevice(const SurfaceObstacle& surface, DeviceArrays& arrays) {
  SurfaceView view = surface.view();
  // Copies `size` numbers of the host and lets the view point to the copy.
  const auto upload = [&]<class T>(std::size_t size, const T*& pointer) {
    pointer = arrays.Upload(std::span<const T>(pointer, size));
  };
  const auto vertices = static_cast<std::size_t>(surface.x().cols());
  const std::size_t triangles = surface.triangles().size();
  upload(3 * vertices, view.x);
  upload(3 * vertices, view.corner_normal);
  upload(3 * triangles, view.corner);
  upload(3 * triangles, view.neighbour);
  upload(triangles, view.counted);
  upload(3 * triangles, view.centre);
  upload(triangles, view.radius);
  upload(3 * triangles, view.face_normal);
  upload(surface.lists().cell_start.size(), view.cell_start);
  upload(surface.lists().cell_triangle.size(), view.cell_triangle);
  return view;
}

SolidContact OnDevice(const Contact& contact, DeviceArrays& arrays) {
  std::vector<Solid> solids;
  bool has_meshes = false;
  for (const Obstacle& obstacle : contact.obstacles) {
    solids.push_back(MakeSolid(obstacle));
    if (const auto* mesh = std::get_if<std::shared_ptr<const SurfaceObstacle>>(&obstacle)) {
      solids.back().surface = OnDevice(**mesh, arrays);
      has_meshes = true;
    }
  }
  return {2.0 * contact.offset(),          contact.range,         contact.stiffness,
          static_cast<int>(solids.size()), arrays.Upload(solids), has_meshes};
}

}  // namespace

DeviceCloth::DeviceCloth(std::shared_ptr<const ClothModel> model, const FrontPlan& plan,
                         int shared_bytes)
    : model_(std::move(model)),
      position_(plan.position),
      multifrontal_(plan, shared_bytes),
      law_(OnDevice(model_->law, arrays_)) {
  const Scene& scene = model_->scene;
  const Mesh mesh = Renumber(model_->mesh, plan);
  const BlockPattern pattern = MakeBlockPattern(mesh, scene.stretch, scene.bend);
  const GatherList to_entry = GatherEntries(plan, mesh, scene);
  view_.num_vertices = mesh.num_vertices();
  view_.num_faces = scene.stretch ? mesh.num_faces() : 0;
  view_.num_hinges = scene.bend ? mesh.num_hinges() : 0;
  view_.num_entries = static_cast<int>(plan.entries.size());
  view_.num_blocks = pattern.num_blocks();
  view_.faces = arrays_.Upload(mesh.faces);
  view_.hinges = arrays_.Upload(mesh.hinges);
  view_.vertex_area = arrays_.Upload(Areas(*model_, position_));
  view_.rest_x = arrays_.Upload(std::span(mesh.rest_x.data(), mesh.rest_x.size()));
  view_.handle = arrays_.Upload(HandleStiffness(*model_, position_));
  view_.load = arrays_.Upload(Loads(*model_, position_));
  for (int k = 0; k < 3; ++k) view_.gravity[k] = scene.gravity ? (*scene.gravity)[k] : 0.0;
  view_.entries = multifrontal_.view().entries;
  view_.row_start = arrays_.Upload(pattern.row_start);
  view_.column = arrays_.Upload(pattern.column);
  view_.mirror = arrays_.Upload(MirrorBlocks(pattern));
  view_.to_entry = OnDevice(to_entry, arrays_);
  view_.entry_order = arrays_.Upload(OrderByWork(to_entry, kElementThreads));
  view_.entry_block = arrays_.Upload(BlocksOfEntries(pattern, plan));
  view_.to_vertex = OnDevice(GatherVertices(mesh, scene), arrays_);
  if (!scene.contact) return;
  view_.contact = OnDevice(*scene.contact, arrays_);
  view_.diagonal_entry = arrays_.Upload(DiagonalEntries(plan));
}

void DeviceCloth::ToEliminationOrder(const double* mesh_order, int columns, int stride,
                                     double* to) const {
  for (std::size_t i = 0; i < position_.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const double* from = mesh_order + (3 * i + k) * columns;
      double* row = to + (3LL * position_[i] + k) * stride;
      std::fill(std::copy_n(from, columns, row), row + stride, 0.0);
    }
}

void DeviceCloth::ToMeshOrder(const double* elimination_order, int columns, int stride,
                              double* to) const {
  for (std::size_t i = 0; i < position_.size(); ++i)
    for (int k = 0; k < 3; ++k)
      std::copy_n(elimination_order + (3LL * position_[i] + k) * stride, columns,
                  to + (3 * i + k) * columns);
}

DeviceMaterials::DeviceMaterials(std::span<const MaterialField* const> materials) {
  std::vector<StretchTable> stretch;
  std::vector<BendTable> bend;
  struct Place {
    std::size_t stretch, bend;
  };
  std::map<const MaterialField*, Place> places;
  for (const MaterialField* m : materials) {
    if (!places.try_emplace(m, Place{stretch.size(), bend.size()}).second) continue;
    stretch.insert(stretch.end(), m->stretch.begin(), m->stretch.end());
    bend.insert(bend.end(), m->bend.begin(), m->bend.end());
  }
  const StretchTable* const stretches = tables_.Upload(stretch);
  const BendTable* const bends = tables_.Upload(bend);
  std::vector<MaterialView> views;
  for (const MaterialField* m : materials) {
    const Place& place = places.at(m);
    views.push_back({m->density,
                     stretches + place.stretch,
                     bends + place.bend,
                     m->stretch.size() == 1 ? 0 : 1,
                     m->bend.size() == 1 ? 0 : 1,
                     m->dynamics.mass_damping,
                     m->dynamics.stiffness_damping,
                     m->dynamics.air_drag,
                     {m->dynamics.wind.x, m->dynamics.wind.y, m->dynamics.wind.z}});
  }
  views_ = DeviceBuffer<MaterialView>(views);
}

}  // namespace drape
