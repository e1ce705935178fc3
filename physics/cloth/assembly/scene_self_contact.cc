// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/assembly/scene_self_contact.h"

#include <glog/logging.h>

#include <utility>
#include <vector>

#include "physics/cloth/contact/step_limit.h"
#include "physics/mesh/self_intersection.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {

bool HasSelfContact(const Scene& scene) { return scene.contact && scene.contact->self; }

SurfaceContact MakeSelfContact(const ClothModel& model) {
  CHECK(HasSelfContact(model.scene));
  return SurfaceContact(model.mesh, model.vertex_area, *model.scene.contact);
}

void RequireThinCloth(const ClothModel& model) {
  if (!HasSelfContact(model.scene)) return;
  const Contact& contact = *model.scene.contact;
  double length = 0.0;
  const std::vector<RestEdge> edges = ListEdges(model.mesh);
  for (const RestEdge& edge : edges) length += edge.rest_length / static_cast<double>(edges.size());
  if (contact.thickness + contact.range <= length) return;
  throw InputError("contact",
                   Format("found cloth of %g mm and a range of %g mm on edges of %.3g mm "
                          "in the mean, expected both together to be less: neighbours "
                          "would touch",
                          1e3 * contact.thickness, 1e3 * contact.range, 1e3 * length));
}

std::optional<SelfOverlap> FindSelfOverlap(const ClothModel& model, const Eigen::VectorXd& x) {
  if (!HasSelfContact(model.scene)) return std::nullopt;
  const std::vector<std::pair<int, int>> meeting =
      FindSelfIntersections(ListTriangles(model.mesh), x);
  if (!meeting.empty()) {
    const auto& [first, second] = meeting.front();
    return SelfOverlap{{model.mesh.faces[first].vertex[0], model.mesh.faces[second].vertex[0]}};
  }
  SurfaceContact contact = MakeSelfContact(model);
  for (const ActivePair& active : contact.FindActivePairs(x))
    if (active.distance.value <= model.scene.contact->thickness)
      return SelfOverlap{{active.pair.vertex[0], active.pair.vertex[3]}, active.distance.value};
  return std::nullopt;
}

double SmallestSelfGap(const ClothModel& model, const Eigen::VectorXd& x) {
  if (!HasSelfContact(model.scene)) return Contact().range;
  SurfaceContact contact = MakeSelfContact(model);
  return contact.SmallestGap(x);
}

Eigen::VectorXd ReachSafely(const ClothModel& model, const Eigen::VectorXd& from,
                            const Eigen::VectorXd& to) {
  if (!HasSelfContact(model.scene) || !to.allFinite()) return to;
  Eigen::VectorXd moves = to - from;
  SurfaceContact contact = MakeSelfContact(model);
  return LimitStep(contact, from, moves) ? from + moves : to;
}

}  // namespace drape
