// SPDX-License-Identifier: Apache-2.0
#include "solver/job/first_answer.h"

#include <cmath>
#include <limits>
#include <utility>

#include "losses/outline/outline.h"
#include "physics/material/material_scaling.h"
#include "physics/util/text_format.h"
#include "solver/forward/outline_pool.h"
#include "solver/job/fit_report.h"

namespace drape {
namespace {

constexpr char kLengthKey[] = "bending_length_overall_cm", kRigidityKey[] = "bending_overall_un_m";
constexpr double kCentimetres = 1e2, kMicro = 1e6;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPerOverhang = 0.12;  // the outline of a pooled drape that is like an image

// Sets the value of a row to c^power·size, as far as an estimate of c bounds it.
LaboratoryRow WithLength(LaboratoryRow row, const PooledLength& found, double power, double size) {
  const auto value = [&](double length) { return size * std::pow(length, power); };
  row.value = value(found.median);
  row.interval = {value(found.low), value(found.high)};
  if (found.reaches_most) {
    row.value = row.interval->low;
    row.interval->high = kInfinity;
  } else if (found.reaches_least) {
    row.value = row.interval->high;
    row.interval->low = -kInfinity;
  }
  return row;
}

// An estimate with the error that the model has beside the pool's spread: drapes of nonlinear
// fabrics are like those of stiffer linear ones.
PooledLength WithModelError(PooledLength found) {
  constexpr double kDeviation = kQuantile90 * kModelDeviation / 3;  // of ln c
  found.low = found.median * std::exp(-std::hypot(std::log(found.median / found.low), kDeviation));
  found.high = found.median * std::exp(std::hypot(std::log(found.high / found.median), kDeviation));
  return found;
}

// The outline in the plane of the support [m], shape [angles]. An observation has a closed one.
Eigen::VectorXd SeeProfile(const Observation& observation, int angles) {
  return VerticalProfile(observation.MeasureRadius(angles).value(), observation.outline_camera(),
                         observation.discs);
}

// Returns whether the pool has drapes like the one that they were found for.
bool IsLike(const OutlinePool& pool, const PooledLength& found) {
  return found.distance <= kPerOverhang * (pool.discs.specimen - pool.discs.support);
}

LaboratoryRow UnknownRow(LaboratoryRow row) {
  row.interval = {-kInfinity, kInfinity};
  row.source = kOriginNotKnown;
  return row;
}

LaboratoryRow LengthRow(const OutlinePool& pool, const PooledLength& found) {
  LaboratoryRow row{.key = kLengthKey, .name = "bending length c, overall", .unit = "cm"};
  if (!IsLike(pool, found)) return UnknownRow(std::move(row));
  row.source = kMeasured;
  return WithLength(std::move(row), found, 1.0, kCentimetres);
}

LaboratorySheet MakeSheet(const OutlinePool& pool, const Observation& observation,
                          const FitInput& input) {
  const PooledLength found =
      WithModelError(EstimateBendingLength(pool, SeeProfile(observation, kPoolAngles)));
  LaboratoryRow rigidity{
      .key = kRigidityKey, .name = "bending rigidity B, overall", .unit = "µN·m"};
  if (IsLike(pool, found)) {
    rigidity.source = input.density_is_given ? kMeasured : kMeasuredIfMass;
    rigidity = WithLength(std::move(rigidity), found, 3.0,
                          kMicro / BendOverWeight(1.0, input.problem.material.density));
  } else {
    rigidity = UnknownRow(std::move(rigidity));
  }
  LaboratorySheet sheet =
      DrapeSheet(MeasureLaboratoryDrape(SeeProfile(observation, kReportAngles), observation.discs),
                 "At once, by pooled drapes like " + observation.name);
  std::erase_if(sheet.rows, [](const LaboratoryRow& row) {
    return row.key != "dc_percent" && row.key != "nodes";
  });
  sheet.rows.insert(sheet.rows.end(), {LengthRow(pool, found), std::move(rigidity)});
  return sheet;
}

}  // namespace

std::vector<LaboratorySheet> AnswerAtOnce(const FitInput& input, const RunControl& control) {
  std::vector<LaboratorySheet> sheets;
  for (const Observation& observation : input.problem.observations) {
    const OutlinePool* pool =
        observation.experiment == nullptr ? FindBuiltInPool(observation.discs) : nullptr;
    if (pool == nullptr) return {};
    const LaboratorySheet sheet = MakeSheet(*pool, observation, input);
    std::string line = observation.name + " at once:";
    for (const LaboratoryRow& row : sheet.rows)
      line += (line.back() == ':' ? " " : "; ") + row.Text();
    control.Log(line);
    sheets.push_back(sheet);
  }
  return sheets;
}

std::optional<LaboratoryRow> AnswerBendingLength(const Eigen::VectorXd& radius,
                                                 const DrapeDiscs& discs) {
  const OutlinePool* pool = FindBuiltInPool(discs);
  if (pool == nullptr) return {};
  const Eigen::VectorXd points =
      radius(Eigen::seqN(0, Eigen::fix<kPoolAngles>, radius.size() / kPoolAngles));
  return LengthRow(*pool, WithModelError(EstimateBendingLength(*pool, points)));
}

std::optional<std::string> FindDisagreement(const LaboratorySheet& at_once,
                                            const LaboratorySheet& fitted) {
  const LaboratoryRow &pooled = at_once.of(kLengthKey), &found = fitted.of(kLengthKey);
  if (!pooled.interval || !found.interval) return std::nullopt;
  if (found.interval->low <= pooled.interval->high && pooled.interval->low <= found.interval->high)
    return std::nullopt;
  return "pooled drapes like the image say otherwise: " + pooled.Text();
}

}  // namespace drape
