// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

namespace drape {

// How well fabrics are recognised by several ways, and by their products.

// One left-out sample: the log probabilities of all fabrics by each way, shape [fabrics], up to a
// constant; a way that has nothing to say of it is missing.
struct RecognisedSample {
  std::string name;
  int fabric = 0;  // the true one, from 0
  std::map<std::string, Eigen::VectorXd> by_way;
};

struct RecognitionScore {
  std::string way;
  bool by_drapes = true;  // else a comparison that does not look at drapes
  int samples = 0;
  double top_1 = 0.0, top_3 = 0.0;  // shares
  double log_loss = 0.0;            // mean −ln p(true fabric) [nat]
  Eigen::MatrixXi confusion;        // true fabric by most probable one
  // By the probability of the most probable fabric, in kReliabilityBins equal bins: count, mean
  // probability, share that is right; shape [kReliabilityBins, 3].
  Eigen::MatrixXd reliability;
};
inline constexpr int kReliabilityBins = 5;

// The logs less that of their sum.
Eigen::VectorXd Normalised(const Eigen::VectorXd& logs);

// Over the samples that have the way; logs are normalised first. At least one fabric.
RecognitionScore ScoreWay(const std::vector<RecognisedSample>& samples, const std::string& way,
                          int fabrics);

// Adds the way `name`, Π p_way^weight with the weights from a grid that have the least log loss
// over the other samples (nested leave-one-out). Samples that lack one of the ways lack it too.
void AddProduct(const std::string& name, const std::vector<std::string>& ways,
                std::vector<RecognisedSample>* samples);

// Markdown: one row per way, then reliability and the confusions of the way by drapes with the
// least log loss.
std::string RecognitionText(const std::vector<RecognitionScore>& scores,
                            const std::vector<std::string>& fabrics);

}  // namespace drape
