// SPDX-License-Identifier: Apache-2.0
// Rendered photographs of samples of known fabrics, and how often intervals of their means hold.
// usage: bench_samples known FILE
//            what is known of the fabrics, over specimens and faces
//        bench_samples photos FOLDER [seed]
//            36 photographs, samples.csv and pictures.csv, their coefficients: 2 fabrics, 3
//            specimens, 2 faces, 3 repeats
//        bench_samples coverage N [mean sd stated]
//            N such experiments by simulated drapes alone, of few vertices. The coefficient of each
//            picture is off by an error of that mean and standard deviation, and states another
//            [points].
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <thread>

#include "cuda/make_backend.h"
#include "losses/metrics/metrics.h"
#include "physics/cloth/state.h"
#include "physics/material/material_io.h"
#include "physics/mesh/disc.h"
#include "physics/util/text_format.h"
#include "solver/fit/effective_stiffness.h"
#include "solver/prediction/exchange/fabric_sheet.h"
#include "tests/losses/photo/rendered/photo_file.h"
#include "tests/losses/photo/rendered/photo_trial.h"
#include "tools/programs/results/tables/sample_report.h"

namespace drape {
namespace {

constexpr const char* kFabrics[] = {"synthetic_wool", "synthetic_shirt"};
constexpr const char* kFaces[] = {"up", "down"};
constexpr int kSpecimens = 3, kRepeats = 3;
constexpr int kVertices = 2400, kFew = 400;  // of the discs
constexpr int kOfMean = 200;                 // drapes of each face that the known mean is of
constexpr double kBendSpread = 0.15;         // of specimens, of the logarithm
constexpr double kStretchSpread = 0.10;      // the same
constexpr double kFaceFactor = 0.10;         // of bending, face up against the mean of both

class Laboratory {
 public:
  Laboratory(unsigned seed, int vertices)
      : model_(std::make_shared<ClothModel>(MakeDisc({.target_vertices = vertices}), CusickScene(),
                                            MakeLaw("smooth"))),
        backend_(MakeBackend("cpu", model_, std::thread::hardware_concurrency())),
        random_(seed) {}

  const Mesh& mesh() const { return model_->mesh; }

  MaterialField CutSpecimen(const std::string& fabric, bool is_up) {
    MaterialField field = Tables(fabric);
    Scale(field, std::exp(kStretchSpread * normal_(random_)),
          std::exp(kBendSpread * normal_(random_)));
    return Turned(field, is_up);
  }
  static MaterialField Turned(MaterialField field, bool is_up) {
    Scale(field, 1.0, std::exp(is_up ? kFaceFactor : -kFaceFactor));
    return field;
  }
  // Drapes of the fields, one each from a random start: positions [m].
  std::vector<Eigen::VectorXd> Hang(const std::vector<MaterialField>& fields) {
    std::vector<State> starts;
    std::vector<RolloutInput> inputs;
    for (std::size_t i = 0; i < fields.size(); ++i) {
      starts.push_back(model_->RestState());
      starts.back().x =
          ApplyStartShape(mesh(), DrapeDiscs().support, RandomStartShape(random_(), 3e-3));
    }
    for (std::size_t i = 0; i < fields.size(); ++i) inputs.push_back({&fields[i], &starts[i]});
    std::vector<Eigen::VectorXd> drapes;
    for (const RolloutResult& each : backend_->Rollouts(inputs, {.h = 0.05, .steps = 60}, nullptr))
      drapes.push_back(each.end.x);
    return drapes;
  }
  double Coefficient(const Eigen::VectorXd& x) const { return ComputeCoefficient(mesh(), x); }
  std::mt19937& random() { return random_; }
  double Normal() { return normal_(random_); }
  // What is known of a fabric over specimens and faces: the mean of its coefficients, and the
  // bending of its tables, as certificates state it, in these drapes.
  struct Known {
    double coefficient = 0.0, rigidity = 0.0, length = 0.0;  // [1], [µN·m], [cm]
  };
  Known FindKnown(const std::string& fabric) {
    Known known;
    std::vector<Eigen::VectorXd> drapes;
    for (const bool is_up : {true, false}) {
      std::vector<MaterialField> fields;
      for (int i = 0; i < kOfMean; ++i) fields.push_back(CutSpecimen(fabric, is_up));
      for (Eigen::VectorXd& x : Hang(fields)) {
        known.coefficient += Coefficient(x) / (2 * kOfMean);
        drapes.push_back(std::move(x));
      }
    }
    const LaboratorySheet sheet =
        MakeFabricSheet({.tables = Tables(fabric),
                         .law = MakeLaw("smooth"),
                         .weights = StiffnessWeights(*model_, drapes),
                         .density_is_given = true},
                        [](const LogQuantity&, Resistance) { return std::nullopt; });
    known.rigidity = sheet.of("bending_overall_un_m").value;
    known.length = sheet.of("bending_length_overall_cm").value;
    return known;
  }

 private:
  static MaterialField Tables(const std::string& fabric) {
    return ReadMaterial(std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/" + fabric + ".json",
                        {.min_relative_stiffness = 0.1})
        .field;
  }
  static void Scale(MaterialField& field, double stretch, double bend) {
    for (int i = 0; i < kStretchRows * kStretchCols; ++i) field.stretch[0].entries()[i] *= stretch;
    for (int i = 0; i < kBendRows * kBendCols; ++i) field.bend[0].entries()[i] *= bend;
  }

  std::shared_ptr<const ClothModel> model_;
  std::unique_ptr<Backend> backend_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

struct Hanging {
  SampleRow row;
  Eigen::VectorXd x;
};

std::vector<Hanging> RunExperiment(Laboratory& laboratory) {
  std::vector<MaterialField> fields;
  std::vector<Hanging> hangings;
  for (const std::string fabric : kFabrics)
    for (int specimen = 1; specimen <= kSpecimens; ++specimen) {
      const MaterialField cut = laboratory.CutSpecimen(fabric, true);
      for (const std::string face : kFaces)
        for (int repeat = 1; repeat <= kRepeats; ++repeat) {
          fields.push_back(
              face == "up" ? cut : Laboratory::Turned(Laboratory::Turned(cut, false), false));
          const std::string name =
              Format("%s_%d_%s_%d.jpg", fabric.c_str(), specimen, face.c_str(), repeat);
          hangings.push_back({.row = {.file = name,
                                      .name = {},
                                      .cells = {{"file", name},
                                                {"fabric", fabric},
                                                {"specimen", std::to_string(specimen)},
                                                {"face", face}}},
                              .x = {}});
        }
    }
  const std::vector<Eigen::VectorXd> drapes = laboratory.Hang(fields);
  for (std::size_t i = 0; i < hangings.size(); ++i) hangings[i].x = drapes[i];
  return hangings;
}

void WriteKnown(const std::string& file) {
  Laboratory laboratory(7, kVertices);
  std::ofstream known(file);
  known << "fabric,dc_percent,bending_overall_un_m,bending_length_overall_cm\n";
  for (const std::string fabric : kFabrics) {
    const Laboratory::Known of = laboratory.FindKnown(fabric);
    known << fabric << "," << 100 * of.coefficient << "," << of.rigidity << "," << of.length
          << std::endl;
  }
}

void RenderSamples(const std::string& folder, unsigned seed) {
  Laboratory laboratory(seed, kVertices);
  std::filesystem::create_directories(folder);
  std::ofstream table(folder + "/samples.csv"), pictures(folder + "/pictures.csv");
  table << "file,fabric,customer,specimen,face,warp,mass,date\n";
  pictures << "file,dc_percent\n";
  unsigned number = 100 * seed;
  for (const Hanging& each : RunExperiment(laboratory)) {
    const std::string fabric = each.row.of("fabric");
    PhotoScene scene = RandomScene(number++);
    scene.width = 1600;
    scene.height = 1200;
    WritePhotoFile(scene, RenderPhoto(scene, {{&laboratory.mesh(), each.x, {0, 0}}}),
                   folder + "/" + each.row.file);
    const double density =
        ReadMaterial(std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/" + fabric + ".json",
                     {.min_relative_stiffness = 0.1})
            .field.density;
    table << each.row.file << "," << fabric << ",," << each.row.of("specimen") << ","
          << each.row.of("face") << ",unknown," << 1000 * density << ",2026-11-30\n";
    pictures << each.row.file << "," << 100 * laboratory.Coefficient(each.x) << "\n";
  }
}

struct Count {
  int held = 0, of = 0;

  void Add(const nlohmann::ordered_json& low, const nlohmann::ordered_json& high, double known) {
    ++of;
    held += low.get<double>() <= known && known <= high.get<double>();
  }
  void Print(const char* what) const {
    std::printf("%-36s %4d of %4d, %.1f %%\n", what, held, of, 100.0 * held / of);
  }
};

void CountCoverage(int experiments, double error_mean, double error_sd, double stated) {
  Laboratory laboratory(7, kFew);
  std::array<double, 2> means_known;
  for (int k = 0; k < 2; ++k) {
    means_known[k] = 100 * laboratory.FindKnown(kFabrics[k]).coefficient;
    std::printf("%s: known mean %.2f %%\n", kFabrics[k], means_known[k]);
  }
  Count means, differences;
  for (int i = 0; i < experiments; ++i) {
    std::vector<MeasuredSample> pictures;
    for (const Hanging& each : RunExperiment(laboratory))
      pictures.push_back({.row = each.row,
                          .coefficient = laboratory.Coefficient(each.x) +
                                         (error_mean + error_sd * laboratory.Normal()) / 100,
                          .coefficient_sd = stated / 100,
                          .nodes = 0});
    const nlohmann::ordered_json samples = SamplesJson(pictures);
    for (const auto& group : samples["groups"])
      if (group["specimen"] == "" && group["face"] == "")
        means.Add(group["dc_low_percent"], group["dc_high_percent"],
                  means_known[group["fabric"] == kFabrics[1]]);
    const auto& difference = samples["differences"][0];
    const double sign = difference["a"] == kFabrics[0] ? 1 : -1;
    differences.Add(difference["low"], difference["high"],
                    sign * (means_known[0] - means_known[1]));
  }
  means.Print("mean of a fabric in its interval");
  differences.Print("difference of two in its interval");
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  const std::string mode = argc > 2 ? argv[1] : "";
  const auto number = [&](int i, double otherwise) {
    return argc > i ? std::atof(argv[i]) : otherwise;
  };
  if (mode == "known") {
    drape::WriteKnown(argv[2]);
  } else if (mode == "photos") {
    drape::RenderSamples(argv[2], static_cast<unsigned>(number(3, 1)));
  } else if (mode == "coverage") {
    drape::CountCoverage(std::atoi(argv[2]), number(3, 0), number(4, 0.2), number(5, 0.4));
  } else {
    std::fputs(
        "usage: bench_samples known FILE | photos FOLDER [seed] | coverage N [mean sd stated]\n",
        stderr);
    return 2;
  }
  return 0;
}
