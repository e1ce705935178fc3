// SPDX-License-Identifier: Apache-2.0
#include "tools/inputs/common_options.h"
#include "tools/programs/garment/garment_tool.h"

namespace drape {
namespace {

std::vector<Option> ClothingOptions(GarmentOptions& options) {
  return {
      {.key = "garment",
       .value = &options.garment,
       .doc = "sewing pattern: configs/garments/circle_skirt.json, another of that format, or a "
              "specification of GarmentCode",
       .is_path = true,
       .required = true},
      {.key = "body",
       .value = &options.body,
       .doc =
           "mannequin:stand, mannequin:walk, mannequin:turn, mannequin:jump, or the OBJ files of "
           "a body of your own, DIR/body_%04d.obj",
       .is_path = true,
       .words = {"mannequin:"}},
      {.key = "body_fps",
       .value = &options.body_fps,
       .doc = "files of a body of your own for each second",
       .unit = "1/s",
       .least = 1,
       .most = 1000},
      {.key = "edge",
       .value = &options.edge,
       .doc = "length of the triangles' edges",
       .unit = "m",
       .least = 0.002,
       .most = 0.1},
  };
}

std::vector<Option> FabricOptions(GarmentOptions& options) {
  return {
      {.key = "material", .value = &options.material, .doc = "material file", .is_path = true},
      {.key = "posterior",
       .value = &options.posterior,
       .doc =
           "instead: output folder of drape_fit, whose posterior is sampled; of a fit without one "
           "the table is taken",
       .is_path = true},
      {.key = "draws",
       .value = &options.draws,
       .doc = "samples of the posterior, one garment each; of a material, starts that differ by "
              "--start_noise",
       .least = 1,
       .most = 1000},
      {.key = "seed",
       .value = &options.seed,
       .doc = "random seed of the samples and of the starts",
       .least = 0,
       .most = 1000000000},
      {.key = "min_relative_stiffness",
       .value = &options.min_relative_stiffness,
       .doc = "smallest table entry relative to the largest of its column",
       .least = 0,
       .most = 1},
  };
}

std::vector<Option> MotionOptions(GarmentOptions& options) {
  WearOptions& wear = options.wear;
  return {
      {.key = "seconds",
       .value = &options.seconds,
       .doc = "simulated time, of which the body takes 1.25 to grow and to lower its arms",
       .unit = "s",
       .least = 0.04,
       .most = 600},
      TimeStepOption(wear.h, "largest time step; a frame of .04 s has a whole number of them"),
      {.key = "tolerance",
       .value = &wear.euler.tolerance,
       .doc = "unbalanced force at the end of a time step, relative to the weight of the garment",
       .least = 1e-10,
       .most = 0.1},
      {.key = "start_noise",
       .value = &wear.start_noise,
       .doc = "random displacement of the cloth before the first step, its standard deviation",
       .unit = "m",
       .least = 0,
       .most = 0.01},
      ThreadsOption(options.threads),
      {.key = "backend",
       .value = &options.backend,
       .doc = "device of the factorisations; auto: a CUDA device if there is one, else the CPU. "
              "The rest is on the CPU",
       .choices = {"auto", "cpu", "cuda"}},
  };
}

std::vector<Option> ContactOptions(WearOptions& wear) {
  return {
      {.key = "thickness",
       .value = &wear.thickness,
       .doc = "thickness of the cloth",
       .unit = "m",
       .least = 0,
       .most = 0.01},
      {.key = "skin_offset",
       .value = &wear.skin_offset,
       .doc = "distance of the vertices of the cloth from the body; edges and faces keep off less",
       .unit = "m",
       .least = 0,
       .most = 0.01},
      {.key = "friction",
       .value = &wear.friction,
       .doc = "coefficient of friction between cloth and body",
       .least = 0,
       .most = 10},
      {.key = "self_contact", .value = &wear.self_contact, .doc = "keep the cloth out of itself"},
      {.key = "self_friction",
       .value = &wear.self_friction,
       .doc = "coefficient of friction of the cloth with itself",
       .least = 0,
       .most = 10},
      {.key = "creep_speed",
       .value = &wear.euler.creep_speed,
       .doc = "relative speed below which contacts that hold creep",
       .unit = "m/s",
       .least = 1e-6,
       .most = 1},
      {.key = "friction_rounds",
       .value = &wear.euler.friction_rounds,
       .doc = "at most so many solutions of a time step, each with the normal forces of the last",
       .least = 1,
       .most = 100},
  };
}

}  // namespace

OptionTable GarmentTable(GarmentOptions& options) {
  return {
      .tool = "drape_garment",
      .summary = "dresses a moving body in a garment of a fitted fabric",
      .example =
          "drape_garment --garment=configs/garments/circle_skirt.json "
          "--body=mannequin:walk --material=configs/fabrics/cotton_blue.json "
          "--out=out/skirt",
      .notes =
          "files: garment.obj and garment.pc2 (its points in 25 frames a second), the same of "
          "the body, sheet.png (eight frames), summary.json; of several draws each in a "
          "folder. In Blender: import the OBJ, add a Mesh Cache modifier with the PC2 file.\n"
          "Ctrl-C keeps the frames so far; --resume continues. exit code 3: a step did not "
          "converge; the frames before it are there\n",
      .options = Concatenate(
          Grouped("garment and body", ClothingOptions(options)),
          Grouped("fabric", FabricOptions(options)),
          Grouped("simulation", Concatenate(MotionOptions(options), ContactOptions(options.wear))),
          Grouped("results", std::vector<Option>{OutOption(options.out),
                                                 {.key = "resume",
                                                  .value = &options.resume,
                                                  .doc = "continue from the frames in --out",
                                                  .repeated = false}})),
      .common = {"garment", "body", "material", "posterior", "draws", "edge", "seconds", "friction",
                 "out"}};
}

}  // namespace drape
