// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "physics/util/options/field.h"
#include "solver/prediction/exchange/exchange_record.h"

namespace drape {

// The programs and formats that a fabric can be taken to [METHODS, P70].
enum class ExportTarget { kArcsim, kClo, kNewton, kStyle3d, kPpf, kBlender, kJson };
constexpr auto EnumNames(ExportTarget) {
  return MakeNames<ExportTarget>({{ExportTarget::kArcsim, "arcsim"},
                                  {ExportTarget::kClo, "clo"},
                                  {ExportTarget::kNewton, "newton"},
                                  {ExportTarget::kStyle3d, "style3d"},
                                  {ExportTarget::kPpf, "ppf"},
                                  {ExportTarget::kBlender, "blender"},
                                  {ExportTarget::kJson, "json"}});
}
inline constexpr ExportTarget kExportTargets[] = {
    ExportTarget::kArcsim, ExportTarget::kClo,     ExportTarget::kNewton, ExportTarget::kStyle3d,
    ExportTarget::kPpf,    ExportTarget::kBlender, ExportTarget::kJson};

// Whether the target bends at the hinges of its mesh, as the reference law does here. A coarse mesh
// of hinges drapes more softly than the fabric [METHODS, P70]. The others: no program, or not
// known.
bool BendsAtHinges(ExportTarget target);

// The faces of the mesh in the target.
enum class FaceKind { kTriangles, kQuads };
constexpr auto EnumNames(FaceKind) {
  return MakeNames<FaceKind>({{FaceKind::kTriangles, "triangles"}, {FaceKind::kQuads, "quads"}});
}

struct ExportOptions {
  FaceKind faces = FaceKind::kTriangles;             // Blender's springs depend on them
  IsotropicChoice keep = IsotropicChoice::kNearest;  // of targets with an isotropic membrane
  double bend_factor = 1.0;  // on all rigidities, for a target that bends at hinges
};

// A fabric in the form of one target.
struct ExportedMaterial {
  std::string file;      // name of the file: "arcsim.json"
  std::string text;      // its content
  MaterialField tables;  // what its numbers mean here, under the reference law if it has hinges
  std::string use;       // how to load it there, in one sentence
  std::vector<std::string> lost;
  bool verified = false;  // drapes of the target itself have been compared
  std::string evidence;   // what has been compared, and what has not
};
ExportedMaterial ExportMaterial(ExportTarget target, const ExchangeRecord& record,
                                const ExportOptions& options = {});

}  // namespace drape
