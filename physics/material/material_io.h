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
  MaterialField field;            // from ReadMaterial: one stretch table, one bend table
  std::string source_convention;  // "mechanical" or "arcsim": convention of the file
  std::string source;             // a note on the origin, may be empty
  std::vector<std::string> warnings;
};

// The name of the fabric configs/fabrics/synthetic_shirt.json as of the build, so that programs
// have a fabric wherever they are put.
inline constexpr char kBuiltInName[] = "built-in";

// What a user says of a fabric.
struct FabricInput {
  std::string path = kBuiltInName;      // ReadMaterial, or a folder of a posterior
  double min_relative_stiffness = 0.0;  // MaterialPolicy
};
template <MutableOrConst<FabricInput> Options, class Visitor>
void VisitFields(Options& options, Visitor&& visit) {
  auto& [path, min_relative_stiffness] = options;
  visit(path, Field{.key = "fabric",
                    .doc = "fabric: a material file, FILE#name where it holds several, "
                           "TABLE.csv#ROW:FILE for a row of bending measurements with the stretch "
                           "of FILE, or a folder of drape_fit",
                    .is_path = true,
                    .word = kBuiltInName});
  visit(min_relative_stiffness,
        Field{.key = "min_relative_stiffness",
              .doc = "table entries below this share of the largest of their column, negative ones "
                     "included, are raised to it",
              .least = 0,
              .most = 1});
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
// "table.csv#ROW:FILE" is a row of bending measurements (ReadBendingRow) with the stretch of FILE.
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

// A short name for columns and files: the stem of the file, and the name or row that is selected
// in it: "felt", "fabrics#felt", "table#12".
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

// The format of files with tables for each element (material_field_io.h).
inline constexpr char kMaterialFieldFormat[] = "drapefit-material-field";

class JsonInput;

// Internal to physics/material: the file that a path names, where it is the folder of a fit.
std::string FindMaterialFile(const std::string& path);

// Internal to physics/material: raises small entries as the policy says.
void RaiseEntries(const std::string& path, const MaterialPolicy& policy, Material* material);

// Internal to physics/material: the largest numbers that files of materials may hold, in the
// mechanical convention: at least 1e3 times the stiffness of fabrics.
inline constexpr double kMinDensity = 1e-5, kMaxDensity = 1e3;  // [kg/m²]
inline constexpr double kMaxMembraneStiffness = 1e8;            // [N/m]
inline constexpr double kMaxRigidity = 100.0;                   // [N·m]

// Read the number at a place of a file. `most`: the largest size of an entry, in its unit. Both
// throw InputError.
double ReadDensity(const JsonInput& input);
double ReadEntry(const JsonInput& input, double most, const MaterialPolicy& policy);

// Bending measurements of many fabrics as one CSV table, in the form of the data set published with
// [Feng 2022]: a line of column names, then one fabric a line, in any order of these columns:
//   density[kg.m-2], linear warp[SI*1e9], linear weft[SI*1e9], linear diag[SI*1e9],
//   nonlinear warp[SI*1e12], nonlinear weft[SI*1e12], nonlinear diag[SI*1e12]
// The moment by length of a curvature κ is M = B1 κ + B2 κ², with B1 = 1e-9 · linear [N·m] and
// B2 = 1e-12 · nonlinear [N·m²]. Such a table has no stretch.

// "table.csv#12:felt.json": row 12 of the table, with the stretch of felt.json.
struct BendingRow {
  std::string table, row;  // row: as the user wrote it; the first below the column names is 1
  std::string base;        // a material file (ReadMaterial); empty: none is named
};
// Returns nothing if the path names no row of a CSV file.
std::optional<BendingRow> SplitBendingRow(const std::string& path);

struct BendingMeasurement {
  double density = 0.0;  // [kg/m²]
  BendTable bend;
};
// Reads one row. The secant stiffness M/κ = B1 + B2 κ is a plate rigidity D, an entry is 4 D
// [MODEL, M8], and column k is that of the curvature 10 k /m, since the column is 0.1 κ
// [MODEL, M19, M26]:  bend[r][k] = 4 (B1 + 10 k B2). Rows are edge directions, and an edge along
// the weft bends the warp [MODEL, M8]: rows 0, 1, 2 are warp, diagonal, weft. From 40 /m on the
// table is constant, where the measured law is not. The measurements belong to directions of
// principal curvature; here, hinges of the edge directions share them. Throws InputError, naming
// the file and the line, for a column that is missing, a row that is not there, and a field that is
// no number; entries may be negative.
BendingMeasurement ReadBendingRow(const BendingRow& row);

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
