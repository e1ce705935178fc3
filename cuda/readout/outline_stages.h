// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cuda/kernels/cloth/mesh_view.h"
#include "cuda/readout/read_status.h"
#include "losses/outline/outline_ray.h"

namespace drape {

// What the outlines of a batch share.
struct OutlinePlan {
  MeshView mesh;
  int num_angles;
};

// One outline: what is read, the workspace, what is found.
struct OutlineSlot {
  const double* x;       // [3V]
  const double* target;  // [K]; null where there is no loss
  double sigma;
  Projection camera;

  Vec2* points;    // [num_hem]
  double* radius;  // [K]
  int* dof;        // [K, 6] ∂r/∂x: places in x …
  double* value;   // [K, 6] … and entries; both zero from the start
  double* loss;    // [1]
  double* dL_dx;   // ∂loss/∂x [3V]; zero from the start
  int* status;     // [1] ReadStatus
};

// From the positions to r(θ), its derivative, the loss and its derivative
// (losses/outline/outline.h), item by item as in border_stages.h.
namespace outline {

// i: vertex of the hem.
struct ProjectHemVertex {
  DRAPE_HD void operator()(const OutlinePlan& plan, const OutlineSlot& s, int i) const {
    if (!ProjectHemPoint(s.camera, s.x + 3 * plan.mesh.border[2 * i], s.points + i))
      *s.status = kUnreadable;
  }
};
// i: angle. The hem's segments are in the order of the host, so that ties are resolved alike.
struct ReadRay {
  DRAPE_HD void operator()(const OutlinePlan& plan, const OutlineSlot& s, int i) const {
    const Vec2 ray = RayDirection(i, plan.num_angles);
    RayCrossing crossing;
    for (int k = 0; k < plan.mesh.num_hem; ++k)
      CrossRay(ray, s.points[k], s.points[(k + 1) % plan.mesh.num_hem], k, &crossing);
    s.radius[i] = crossing.radius;
    if (crossing.segment < 0) {
      *s.status = kUnreadable;
      return;
    }
    const int* vertex = plan.mesh.border + 2 * crossing.segment;
    const Vec2 edge =
        s.points[(crossing.segment + 1) % plan.mesh.num_hem] - s.points[crossing.segment];
    RadiusByEnds(s.camera, ray, edge, crossing.t, s.x + 3 * vertex[0], s.x + 3 * vertex[1],
                 s.value + 6 * i);
    for (int e = 0; e < 6; ++e) s.dof[6 * i + e] = 3 * vertex[e / 3] + e % 3;
  }
};

// i: 0.
struct SumLoss {
  DRAPE_HD void operator()(const OutlinePlan& plan, const OutlineSlot& s, int) const {
    double sum = 0.0;
    for (int k = 0; k < plan.num_angles; ++k) {
      const double residual = (s.radius[k] - s.target[k]) / s.sigma;
      sum += residual * residual;
    }
    *s.loss = 0.5 * sum;
  }
};
// i: vertex of the hem.
struct AdjHemVertex {
  DRAPE_HD void operator()(const OutlinePlan& plan, const OutlineSlot& s, int i) const {
    const int dof = 3 * plan.mesh.border[2 * i];
    double sum[3] = {0.0, 0.0, 0.0};
    for (int k = 0; k < plan.num_angles; ++k) {
      const double adjoint = (s.radius[k] - s.target[k]) / (s.sigma * s.sigma);
      for (int end = 0; end < 2; ++end) {
        if (s.dof[6 * k + 3 * end] != dof) continue;
        for (int d = 0; d < 3; ++d) sum[d] += adjoint * s.value[6 * k + 3 * end + d];
      }
    }
    for (int d = 0; d < 3; ++d) s.dL_dx[dof + d] = sum[d];
  }
};

}  // namespace outline

// The stages of a batch of outlines; a runner as in silhouette_run.h.
template <class Runner>
void RunOutlines(const OutlinePlan& plan, Runner& run) {
  run.Each(outline::ProjectHemVertex(), plan.mesh.num_hem);
  run.Each(outline::ReadRay(), plan.num_angles);
}
template <class Runner>
void RunOutlineLoss(const OutlinePlan& plan, Runner& run) {
  run.Each(outline::SumLoss(), 1);
  run.Each(outline::AdjHemVertex(), plan.mesh.num_hem);
}

}  // namespace drape
