// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "physics/cloth/cloth_model.h"
#include "physics/cloth/scene_io.h"
#include "physics/cloth/state.h"
#include "solver/prediction/prediction.h"

namespace drape {

// The cloth, the scene and the start of a drape, as a user names them.
struct SceneInput {
  std::string mesh = "disc:1200";  // ParseMeshSpec
  FabricInput fabric;              // with an empty path: none
  std::string law = "smooth";      // MakeLaw
  std::string scene = "cusick";    // "cusick", or a scene file (ReadScene)
  CusickContact contact;           // of the former
  DiscsInput discs;                // FindDiscs
  std::string start = "flat";      // "flat", or a start shape or state file (ReadStart)
};

template <MutableOrConst<SceneInput> Options, class Visitor>
void VisitFields(Options& options, Visitor&& visit) {
  auto& [mesh, fabric, law, scene, contact, discs, start] = options;
  visit(mesh, Field{.key = "mesh",
                    .doc = "cloth: an OBJ file, disc:N for a built-in disc of N vertices, or "
                           "strip:LENGTHxWIDTHxN for a strip [m] with N edges along its length",
                    .is_path = true,
                    .words = {"disc:", "strip:"}});
  VisitFields(fabric, visit);
  visit(law, Field{.key = "law",
                   .doc = "constitutive law: how stiffness depends on strain and curvature",
                   .choices = {"reference", "smooth"}});
  VisitFields(contact, visit);
  VisitFields(discs, visit);
  visit(start, Field{.key = "start",
                     .doc = "initial shape: flat, or the file of a start shape or a state",
                     .is_path = true,
                     .words = {"flat"}});
  visit(scene, Field{.key = "scene",
                     .doc = "loads and supports: cusick, or a scene file, such as "
                            "configs/scenes/two_corners.json",
                     .is_path = true,
                     .words = {"cusick"}});
}

struct LoadedScene {
  std::shared_ptr<const ClothModel> model;
  FabricSource fabric;
  State start;
  DrapeDiscs discs;
};

// Reads and checks all of it; warnings about the material go to the log. The reference law takes
// float32 coordinates and negative entries, as the reference simulator does. Throws InputError,
// also where the scene holds no vertex or loads no edge of the mesh, or a start shape has no
// support.
LoadedScene LoadScene(const SceneInput& input);

// The parts of LoadScene for a mesh and a start that are there already; input.mesh and input.start
// are what messages call them.
std::shared_ptr<const ClothModel> MakeSceneModel(const SceneInput& input, Mesh mesh,
                                                 const DrapeDiscs& discs);
// Throws InputError for a start in an obstacle or one that passes through itself, where the scene
// has such contact.
void RequireFreeStart(const SceneInput& input, const ClothModel& model, const State& start);

// Throws InputError, prefix "option '<option>'", for a material with a table for each element:
// what the option does is by the 39 entries of one table.
void RequireOneTable(const Material& material, const std::string& option);

}  // namespace drape
