// SPDX-License-Identifier: Apache-2.0
// Dresses a mannequin in a garment of a fabric and writes its surface. Garments are not part of the
// installed library: their headers may change.
// usage: 06_garment <pattern.json> <fabric.json> <surface.obj>
#include <cstdio>
#include <memory>

#include "physics/mesh/obj_io.h"
#include "solver/drapefit.h"
#include "solver/prediction/garment/body/body.h"
#include "solver/prediction/garment/pattern/pattern.h"
#include "solver/prediction/garment/wear.h"

int main(int argc, char** argv) {
  using namespace drape;
  if (argc != 4) return 2;
  // A pattern: panels and the seams that join them. A body: a mannequin, with its arms lifted for
  // dressing, that can stand, walk, turn or jump.
  const Pattern pattern = ReadPattern(argv[1]);
  const std::unique_ptr<Body> body = ParseBody("mannequin:stand", pattern.arm_angle);
  // The panels as triangles with edges of 4 cm, sewn into one cloth around the body.
  const GarmentMesh panels = MakeGarmentMesh(pattern, 0.04, argv[1]);
  const SewnGarment garment = Sew(panels, MakeLaw("smooth"));
  // 5 frames of 0.04 s, in steps of 0.01 s, with contact and friction.
  const WearOptions options{.frames = 5};
  const State start = StartToWear(garment, *body, options);
  if (FindStartPiercing(garment, *body, options, start) || FindStartIntersection(garment, start))
    return 1;
  WornFrame last;
  const WearResult worn = Wear(garment, ReadMaterial(argv[2]).field, *body, options, start, 0, {},
                               [&](const WornFrame& frame) { last = frame; });
  if (worn.status != WearStatus::kDone) {
    std::printf("%s\n", worn.reason.c_str());
    return 1;
  }
  std::printf("%s: %d vertices, %.2f s, at least %.1f mm from the body, stretched by %.1f %%\n",
              pattern.name.c_str(), garment.model->mesh.num_vertices(), last.time,
              1e3 * last.smallest_gap, 100.0 * last.largest_stretch);
  // The garment in the last frame, to be seen in any program that reads OBJ.
  WriteObj(argv[3], ObjSurface{last.cloth.x, ListTriangles(garment.model->mesh)});
  return last.body_intersections + last.self_intersections == 0 ? 0 : 1;
}
