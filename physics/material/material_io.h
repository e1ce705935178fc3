// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "physics/material/material.h"
#include "physics/mesh/mesh.h"
#include "physics/util/options/field.h"

namespace drape {

// Meaning of the numbers in a file [MODEL, M9].
enum class Convention {
  kMechanical,  // stretch = membrane stiffness [N/m], bend = plate rigidity D [N·m]
  kArcsim,      // table entries of material.h: half the stiffness, four times D
};

enum class NegativeEntries {
  kReject,  // smooth law: a negative stiffness has no meaning
  kWarn,    // reference law: kept with a warning; the law clamps samples at 0 [MODEL, M16]
};

struct MaterialPolicy {
  NegativeEntries negative_entries = NegativeEntries::kReject;
  // RaiseSmallEntries, with a warning, instead of the policy for negative entries. 0: not raised.
  double min_relative_stiffness = 0.0;

  bool warns() const {
    return negative_entries == NegativeEntries::kWarn && min_relative_stiffness == 0.0;
  }
  bool rejects() const {
    return negative_entries == NegativeEntries::kReject && min_relative_stiffness == 0.0;
  }
};

// A fabric and its origin.
struct Material {
  std::string name;
  MaterialField field;  // from ReadMaterial: one stretch table, one bend table
  std::string source_convention = "mechanical";  // or "arcsim": convention of the file
  std::string source = {};                       // a note on the origin, may be empty
  std::vector<std::string> warnings = {};
  bool warp_known = true;  // false: warp and weft may be exchanged, "warp": "unknown" in the file
};

// The name of the fabric configs/fabrics/synthetic_shirt.json as of the build, so that programs
// have a fabric wherever they are put.
inline constexpr char kBuiltInName[] = "built-in";
extern const char* const kBuiltInFabric;  // its text

// What a user says of a fabric.
struct FabricInput {
  std::string path = kBuiltInName;      // ReadMaterial, or a folder of a posterior
  double min_relative_stiffness = 0.0;  // MaterialPolicy
};
template <MutableOrConst<FabricInput> Options, class Visitor>
void VisitFields(Options& options, Visitor&& visit) {
  auto& [path, min_relative_stiffness] = options;
  visit(path,
        Field{.key = "fabric",
              .doc = "fabric: a name that drape_fabrics lists, a material file, FILE#name, or a "
                     "folder of drape_fit",
              .is_path = true,
              .words = {kBuiltInName},
              .presets = "fabrics"});
  visit(min_relative_stiffness,
        Field{.key = "min_relative_stiffness",
              .doc = "table entries below this share of the largest of their column, negative ones "
                     "included, are raised to it",
              .range = {.least = 0, .most = 1}});
}

// Reads one fabric: the built-in one, the material.json of a folder of drape_fit, or a JSON file
// (comments are allowed) in one of three formats:
//  - ours: {"format": "drapefit-material", "version": 1, "convention": "mechanical" | "arcsim",
//    "density" [kg/m²], "stretch" [6][4], "bend" [3][5], optional "name", "units": "SI", "source"};
//  - published start tables: "density", "c11" "c12" "c22" "c33" [6] each, "bending" [3][5]
//    (arcsim convention; *_prior_std are ignored);
//  - ARCSim: "density", "stretching" [6][4], "bending" [3][5]; its damping, strain-limit and
//    plasticity keys, and the bending moduli of [Feng 2022], are ignored with a warning.
// A file may hold several fabrics as {"name": {…}, …}; "path#name" selects one.
// Throws InputError, naming the file and the key with its index, for a syntax error, a wrong shape,
// a number that is not finite, an unknown key (the message lists the allowed ones), a density or an
// entry far out of the range of fabrics, negative entries that the policy rejects (the message
// lists all of them), tables for each element, and a file of several fabrics without a selection
// (the message lists them).
Material ReadMaterial(const std::string& path, const MaterialPolicy& policy = {});

// "path#name" as path and name. A "#" belongs to the path where a file of the whole name exists, or
// none of the name before it, as in "folder#1/file.json".
struct MaterialPath {
  std::string file, name;
};
MaterialPath SplitMaterialPath(const std::string& path);

// A short name for columns and files: the stem of the file, and the name that is selected in it:
// "felt", "fabrics#felt".
std::string MaterialLabel(const std::string& path);

// Parses a text in one of these formats. where: its name in messages, and the name of a fabric
// without one.
Material ParseMaterial(const std::string& text, const std::string& where,
                       const MaterialPolicy& policy = {});

// Our format. Numbers read back bit for bit in both conventions. CHECKs as WriteMaterial.
std::string MaterialText(const Material& material, Convention convention = Convention::kMechanical);

// Writes our format atomically. Numbers read back bit for bit in both conventions. CHECKs that the
// field has one table of each kind. Throws InputError when the file cannot be written.
void WriteMaterial(const std::string& path, const Material& material,
                   Convention convention = Convention::kMechanical);

// The format of files with tables for each element.
inline constexpr char kMaterialFieldFormat[] = "drapefit-material-field";

// Files of a fabric whose tables vary over the cloth. Such a file holds one table for each face and
// each hinge of the mesh on which it was estimated, with the material coordinates of the element:
//   {"format": "drapefit-material-field", "version": 1, "convention": "mechanical", "density",
//    "face_centres" [F][2] (uv in metres), "stretch" [F][24] (rows of [6][4]),
//    "hinge_centres" [E][2], "bend" [E][15] (rows of [3][5]), optional "name", "units", "source"}.

// Writes the file atomically. CHECKs that the field has a table for each face and hinge. Throws
// InputError when the file cannot be written.
void WriteMaterialField(const std::string& path, const Material& material, const Mesh& mesh);

// Reads a file of either kind, of one table (ReadMaterial) or of a field. In the latter case each
// element of `mesh` gets the table of the nearest element in the file, so that the tables come back
// bit for bit on the mesh of the file. Throws InputError as ReadMaterial does.
Material ReadMaterialFor(const Mesh& mesh, const std::string& path,
                         const MaterialPolicy& policy = {});

}  // namespace drape
