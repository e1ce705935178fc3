// SPDX-License-Identifier: Apache-2.0
#include "cuda/kernels/cloth/device_cloth.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <span>
#include <utility>
#include <variant>

namespace drape {
namespace {

// Copies `size` numbers of the host and lets the view point to the copy.
template <class T>
void Upload(std::size_t size, DeviceBuffer<T>& to, const T*& pointer) {
  to = DeviceBuffer<T>(std::span<const T>(pointer, size));
  pointer = to.data();
}

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

Law OnDevice(Law law, DeviceBuffer<StretchNode>& nodes) {
  if (const auto* reference = std::get_if<ReferenceStretch>(&law.stretch)) {
    constexpr int kNodes = kStrainNodes * kStrainNodes * kStrainNodes;
    nodes = DeviceBuffer<StretchNode>(std::span(reference->nodes(), kNodes));
    law.stretch = ReferenceStretch(nodes.data());
  }
  return law;
}

}  // namespace

DeviceSurface::DeviceSurface(const SurfaceObstacle& surface) : view_(surface.view()) {
  const auto vertices = static_cast<std::size_t>(surface.x().cols());
  const std::size_t triangles = surface.triangles().size();
  Upload(3 * vertices, x_, view_.x);
  Upload(3 * vertices, corner_normal_, view_.corner_normal);
  Upload(3 * triangles, corner_, view_.corner);
  Upload(3 * triangles, neighbour_, view_.neighbour);
  Upload(triangles, counted_, view_.counted);
  Upload(3 * triangles, centre_, view_.centre);
  Upload(triangles, radius_, view_.radius);
  Upload(3 * triangles, face_normal_, view_.face_normal);
  Upload(surface.lists().cell_start.size(), cell_start_, view_.cell_start);
  Upload(surface.lists().cell_triangle.size(), cell_triangle_, view_.cell_triangle);
}

DeviceCloth::DeviceCloth(std::shared_ptr<const ClothModel> model, const FrontPlan& plan,
                         int shared_bytes)
    : model_(std::move(model)),
      position_(plan.position),
      multifrontal_(plan, shared_bytes),
      vertex_area_(Areas(*model_, position_)),
      handle_(HandleStiffness(*model_, position_)),
      load_(Loads(*model_, position_)),
      law_(OnDevice(model_->law, strain_nodes_)) {
  const Scene& scene = model_->scene;
  const Mesh mesh = Renumber(model_->mesh, plan);
  const BlockPattern pattern = MakeBlockPattern(mesh, scene.stretch, scene.bend);
  faces_ = DeviceBuffer<Face>(mesh.faces);
  hinges_ = DeviceBuffer<Hinge>(mesh.hinges);
  rest_x_ = DeviceBuffer<double>(std::span(mesh.rest_x.data(), mesh.rest_x.size()));
  row_start_ = DeviceBuffer<int>(pattern.row_start);
  column_ = DeviceBuffer<int>(pattern.column);
  mirror_ = DeviceBuffer<int>(MirrorBlocks(pattern));
  entry_block_ = DeviceBuffer<int>(BlocksOfEntries(pattern, plan));
  const GatherList to_entry = GatherEntries(plan, mesh, scene);
  to_entry_ = std::make_unique<Gather>(to_entry);
  entry_order_ = DeviceBuffer<int>(OrderByWork(to_entry, kElementThreads));
  to_vertex_ = std::make_unique<Gather>(GatherVertices(mesh, scene));
  view_.num_vertices = mesh.num_vertices();
  view_.num_faces = scene.stretch ? mesh.num_faces() : 0;
  view_.num_hinges = scene.bend ? mesh.num_hinges() : 0;
  view_.num_entries = static_cast<int>(plan.entries.size());
  view_.num_blocks = pattern.num_blocks();
  view_.faces = faces_.data();
  view_.hinges = hinges_.data();
  view_.vertex_area = vertex_area_.data();
  view_.rest_x = rest_x_.data();
  view_.handle = handle_.data();
  view_.load = load_.data();
  for (int k = 0; k < 3; ++k) view_.gravity[k] = scene.gravity ? (*scene.gravity)[k] : 0.0;
  view_.entries = multifrontal_.view().entries;
  view_.row_start = row_start_.data();
  view_.column = column_.data();
  view_.mirror = mirror_.data();
  view_.to_entry = to_entry_->view();
  view_.entry_order = entry_order_.data();
  view_.entry_block = entry_block_.data();
  view_.to_vertex = to_vertex_->view();
  if (!scene.contact) return;
  view_.contact = UploadContact(*scene.contact);
  diagonal_entry_ = DeviceBuffer<int>(DiagonalEntries(plan));
  view_.diagonal_entry = diagonal_entry_.data();
}

SolidContact DeviceCloth::UploadContact(const Contact& contact) {
  std::vector<Solid> solids;
  for (const Obstacle& obstacle : contact.obstacles) {
    solids.push_back(MakeSolid(obstacle));
    if (const auto* mesh = std::get_if<std::shared_ptr<const SurfaceObstacle>>(&obstacle))
      solids.back().surface = surfaces_.emplace_back(**mesh).view();
  }
  solids_ = DeviceBuffer<Solid>(solids);
  return {2.0 * contact.offset(),          contact.range,  contact.stiffness,
          static_cast<int>(solids.size()), solids_.data(), !surfaces_.empty()};
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
  stretch_ = DeviceBuffer<StretchTable>(stretch);
  bend_ = DeviceBuffer<BendTable>(bend);
  std::vector<MaterialView> views;
  for (const MaterialField* m : materials) {
    const Place& place = places.at(m);
    views.push_back({m->density, stretch_.data() + place.stretch, bend_.data() + place.bend,
                     m->stretch.size() == 1 ? 0 : 1, m->bend.size() == 1 ? 0 : 1});
  }
  views_ = DeviceBuffer<MaterialView>(views);
}

}  // namespace drape
