// SPDX-License-Identifier: Apache-2.0
// Makes a pool from which fits start, a file of solver/forward/pools.
// usage: make_pool --out=solver/forward/pools/disc_30_18.pool --specimen=0.30 [--drapes=16384]
//   --pool: reads the drapes of discs of 30 cm on 18 cm from a pool of drape_predict instead
// A function of its options: another device gives the same drapes but for rounding.
#include <gflags/gflags.h>
#include <glog/logging.h>

#include <cstdio>
#include <fstream>
#include <memory>

#include "cuda/make_backend.h"
#include "physics/cloth/cloth_model.h"
#include "physics/cloth/scene.h"
#include "physics/material/laws/law_kind.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/run_control.h"
#include "solver/forward/outline_pool.h"

DEFINE_string(out, "", "the file");
DEFINE_double(specimen, 0.30, "diameter of the flat specimen [m]; the support has 18 cm");
DEFINE_int32(drapes, 16384, "simulated drapes, of which some do not come to rest");
DEFINE_string(mesh, "disc:1200", "cloth");
DEFINE_string(pool, "", "file of a pool");
DEFINE_int32(threads, 2, "threads");

int main(int argc, char** argv) {
  using namespace drape;
  gflags::ParseCommandLineFlags(&argc, &argv, true);
  google::InitGoogleLogging(argv[0]);
  PoolOptions options{
      .mesh = FLAGS_mesh, .discs = {.specimen = FLAGS_specimen / 2}, .drapes = FLAGS_drapes};
  const auto model = std::make_shared<const ClothModel>(
      ParseMeshSpec(options.mesh, {}, options.discs), CusickScene({}, options.discs.support),
      MakeLaw(LawKind::kSmooth));
  DrapePool pool;
  if (FLAGS_pool.empty()) {
    std::string device;
    const std::unique_ptr<Backend> backend = MakeBackend("auto", model, FLAGS_threads, &device);
    RunControl control;
    control.progress = [](double share, const std::string& note) {
      std::fprintf(stderr, "%3.0f %%  %s\n", 100 * share, note.c_str());
    };
    pool = SimulatePool(*backend, options, control);
  } else {
    pool = ReadPool(FLAGS_pool);
  }
  OutlinePool packed;
  packed.mesh = pool.mesh;
  packed.setting = pool.setting;
  packed.discs = options.discs;
  packed.seed = pool.seed;
  for (const PooledDrape& drape : pool.drapes) {
    packed.numbers.push_back(drape.numbers);
    packed.radius.push_back(drape.shape.radius);
  }
  std::ofstream(FLAGS_out, std::ios::binary) << PackPool(packed);
  std::printf("%s: %d drapes of %d\n", FLAGS_out.c_str(), packed.num_drapes(), pool.simulated);
}
