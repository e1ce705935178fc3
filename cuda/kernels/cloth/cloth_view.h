// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime_api.h>

#include <cstdint>

#include "cuda/factor/plan/front_plan.h"
#include "physics/cloth/contact/vertex_contact.h"
#include "physics/material/laws/bend_element.h"
#include "physics/material/laws/law.h"
#include "physics/material/laws/stretch_element.h"

namespace drape {

// Threads of a block of the kernels over elements, over matrix blocks and over vertices.
inline constexpr int kElementThreads = 128;

// A GatherList in device memory.
struct GatherView {
  const int *start, *item;
};

// What all rollouts of a model share, in device memory and elimination order.
struct ClothView {
  int num_vertices, num_faces, num_hinges;  // faces and hinges that act in the scene
  int num_entries;                          // lower-triangle blocks, as in FrontPlan
  int num_blocks;                           // of the full pattern
  const Face* faces;
  const Hinge* hinges;
  const double* vertex_area;  // [V]
  const double* rest_x;       // [3V]
  const double* handle;       // spring of each vertex, 0 where it is free [N/m], [V]
  const double* load;         // dead loads [N], [3V]
  double gravity[3];          // [m/s²]
  const FrontEntry* entries;
  const int *row_start, *column, *mirror;  // full pattern; mirror: block (j, i) of block (i, j)
  const int* entry_block;                  // block of the full pattern of each entry
  GatherView to_entry, to_vertex;
  const int* entry_order;  // OrderByWork of to_entry by kElementThreads, [num_entries]
  SolidContact contact;
  const int* diagonal_entry;  // the entry of each vertex with itself, [V]; null without contact

  DRAPE_HD int num_dofs() const { return 3 * num_vertices; }
};

// The fabric of one rollout; a stride is 0 for one table and 1 for one each element.
struct MaterialView {
  double density;  // [kg/m²]
  const StretchTable* stretch;
  const BendTable* bend;
  int stretch_stride, bend_stride;
  double mass_damping, stiffness_damping;  // α [1/s], β [s]
  double air_drag;                         // c [kg/m³]
  double wind[3];                          // [m/s]
};

// What a step needs to know of an element at a shape.
struct FaceRecord {
  DeformationGradient<double> F;
  StretchCoefficients<double> k;
};
struct HingeRecord {
  HingeGradient gradient;    // ∂θ/∂x
  double moment, stiffness;  // κ·μ and its slope at a fixed κ
};

// Records of the elements of a batch by slot.
template <class OfFace, class OfHinge>
struct BatchRecords {
  OfFace* faces;    // [F]
  OfHinge* hinges;  // [E]

  // The records of the slots from `first` on.
  DRAPE_HD BatchRecords From(const ClothView& cloth, std::int64_t first) const {
    return {faces + first * cloth.num_faces, hinges + first * cloth.num_hinges};
  }
};
using StepRecords = BatchRecords<FaceRecord, HingeRecord>;

// A batch of shapes: slot s holds rollout `rollout[s]`, or s where that is null.
struct ShapeBatch {
  int slots;
  int all_slots;  // of all concurrent streams
  const int* rollout;
  const MaterialView* material;  // by rollout
  const double* x;               // by rollout, [3V]
};

// What the kernels over a batch of shapes work on, and where they are launched.
struct LaunchContext {
  const ClothView& cloth;
  ShapeBatch batch;
  const Law& law;  // its tables lie on the device
  cudaStream_t stream;
};

}  // namespace drape
