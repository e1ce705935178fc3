// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/recognition/recognition_scores.h"

#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "physics/util/text_format.h"

namespace drape {
namespace {

constexpr std::array<double, 11> kExponents = {0.0, 0.1, 0.25, 0.5, 0.75, 1.0,
                                               1.5, 2.0, 3.0,  4.0, 6.0};

// How many fabrics are more probable; of equals those before.
int Rank(const Eigen::VectorXd& logs, int fabric) {
  int rank = 0;
  for (int f = 0; f < logs.size(); ++f)
    rank += logs[f] > logs[fabric] || (logs[f] == logs[fabric] && f < fabric) ? 1 : 0;
  return rank;
}

// The weights number `index` of the grid.
std::vector<double> WeightsAt(int index, std::size_t ways) {
  std::vector<double> weights;
  for (std::size_t w = 0; w < ways; ++w, index /= int(kExponents.size()))
    weights.push_back(kExponents[index % kExponents.size()]);
  return weights;
}

Eigen::VectorXd Multiply(const RecognisedSample& sample, const std::vector<std::string>& ways,
                         const std::vector<double>& weights) {
  Eigen::VectorXd logs = Eigen::VectorXd::Zero(sample.by_way.at(ways[0]).size());
  for (std::size_t w = 0; w < ways.size(); ++w)
    logs += weights[w] * Normalised(sample.by_way.at(ways[w]));
  return Normalised(logs);
}

std::string ConfusionText(const RecognitionScore& score, const std::vector<std::string>& fabrics) {
  std::string text;
  for (int f = 0; f < int(fabrics.size()); ++f) {
    const int count = score.confusion.row(f).sum();
    if (count == 0) continue;
    text += Format("| %s | %d of %d |", fabrics[f].c_str(), score.confusion(f, f), count);
    for (int g = 0; g < int(fabrics.size()); ++g)
      if (g != f && score.confusion(f, g) > 0)
        text += Format(" %s: %d;", fabrics[g].c_str(), score.confusion(f, g));
    text += " |\n";
  }
  return text;
}

}  // namespace

Eigen::VectorXd Normalised(const Eigen::VectorXd& logs) {
  const double largest = logs.maxCoeff();
  return logs.array() - (largest + std::log((logs.array() - largest).exp().sum()));
}

RecognitionScore ScoreWay(const std::vector<RecognisedSample>& samples, const std::string& way,
                          int fabrics) {
  RecognitionScore score{.way = way,
                         .confusion = Eigen::MatrixXi::Zero(fabrics, fabrics),
                         .reliability = Eigen::MatrixXd::Zero(kReliabilityBins, 3)};
  for (const RecognisedSample& sample : samples) {
    const auto found = sample.by_way.find(way);
    if (found == sample.by_way.end()) continue;
    const Eigen::VectorXd logs = Normalised(found->second);
    const int rank = Rank(logs, sample.fabric);
    ++score.samples;
    score.top_1 += rank < 1;
    score.top_3 += rank < 3;
    score.log_loss -= logs[sample.fabric];
    int best = 0;
    const double sure = std::exp(logs.maxCoeff(&best));
    ++score.confusion(sample.fabric, best);
    const int bin = std::min(kReliabilityBins - 1, static_cast<int>(sure * kReliabilityBins));
    score.reliability.row(bin) += Eigen::RowVector3d(1.0, sure, best == sample.fabric);
  }
  const double count = std::max(1, score.samples);
  score.top_1 /= count;
  score.top_3 /= count;
  score.log_loss /= count;
  for (int bin = 0; bin < kReliabilityBins; ++bin)
    if (score.reliability(bin, 0) > 0)
      score.reliability.row(bin).tail(2) /= score.reliability(bin, 0);
  return score;
}

void AddProduct(const std::string& name, const std::vector<std::string>& ways,
                std::vector<RecognisedSample>* samples) {
  std::vector<RecognisedSample*> complete;
  for (RecognisedSample& sample : *samples)
    if (std::all_of(ways.begin(), ways.end(),
                    [&](const std::string& way) { return sample.by_way.contains(way); }))
      complete.push_back(&sample);
  if (complete.empty()) return;
  const int grid = static_cast<int>(std::pow(kExponents.size(), ways.size()));
  Eigen::MatrixXd loss(grid, complete.size());
  for (int g = 0; g < grid; ++g)
    for (std::size_t i = 0; i < complete.size(); ++i)
      loss(g, Eigen::Index(i)) =
          -Multiply(*complete[i], ways, WeightsAt(g, ways.size()))[complete[i]->fabric];
  const Eigen::VectorXd total = loss.rowwise().sum();
  for (std::size_t i = 0; i < complete.size(); ++i) {
    int best = 0;
    (total - loss.col(Eigen::Index(i))).minCoeff(&best);
    complete[i]->by_way[name] = Multiply(*complete[i], ways, WeightsAt(best, ways.size()));
  }
}

std::string RecognitionText(const std::vector<RecognitionScore>& scores,
                            const std::vector<std::string>& fabrics) {
  std::string text = "| way | samples | top 1 | top 3 | log loss [nat] |\n|---|---|---|---|---|\n";
  const RecognitionScore* best = nullptr;
  for (const RecognitionScore& score : scores) {
    text += Format("| %s | %d | %.3f | %.3f | %.3f |\n", score.way.c_str(), score.samples,
                   score.top_1, score.top_3, score.log_loss);
    if (score.by_drapes && score.samples > 0 &&
        (best == nullptr || score.log_loss < best->log_loss))
      best = &score;
  }
  if (best == nullptr) return text;
  text += "\nReliability of \"" + best->way +
          "\":\n\n| samples | mean probability of the most probable fabric | share that is right "
          "|\n|---|---|---|\n";
  for (int bin = 0; bin < kReliabilityBins; ++bin)
    if (best->reliability(bin, 0) > 0)
      text += Format("| %.0f | %.2f | %.2f |\n", best->reliability(bin, 0),
                     best->reliability(bin, 1), best->reliability(bin, 2));
  return text + "\nConfusions of \"" + best->way +
         "\":\n\n| fabric | recognised | taken for |\n|---|---|---|\n" +
         ConfusionText(*best, fabrics);
}

}  // namespace drape
