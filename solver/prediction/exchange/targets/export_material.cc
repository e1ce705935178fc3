// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/targets/export_material.h"

#include <glog/logging.h>

#include <nlohmann/json.hpp>

#include "physics/util/atomic_file.h"
#include "solver/prediction/exchange/targets/target_list.h"

namespace drape {
namespace {

ExportedMaterial Dispatch(ExportTarget target, const ExchangeRecord& record,
                          const ExportOptions& options) {
  switch (target) {
    case ExportTarget::kArcsim:
      return ExportArcsim(record);
    case ExportTarget::kClo:
      return ExportClo(record);
    case ExportTarget::kNewton:
      return ExportNewton(record, options.keep);
    case ExportTarget::kStyle3d:
      return ExportStyle3d(record);
    case ExportTarget::kPpf:
      return ExportPpf(record);
    case ExportTarget::kBlender:
      return ExportBlender(record);
    case ExportTarget::kUnreal:
      return ExportUnreal(record);
    case ExportTarget::kU3m:
      return ExportU3m(record);
    case ExportTarget::kUsda:
      return ExportUsda(record);
    case ExportTarget::kJson:
      return ExportJson(record);
  }
  LOG(FATAL) << "no such target";
}

}  // namespace

std::string NumberText(double value) {
  std::string text;
  AppendNumber(text, value);
  return text;
}

std::string QuotedText(const std::string& text) { return nlohmann::json(text).dump(); }

ExportedMaterial ExportMaterial(ExportTarget target, const ExchangeRecord& record,
                                const ExportOptions& options) {
  ExportedMaterial exported = Dispatch(target, record, options);
  const bool keeps_record = target == ExportTarget::kU3m || target == ExportTarget::kJson;
  if (record.source.posterior && !keeps_record) exported.lost.emplace_back(kLosesUncertainty);
  return exported;
}

}  // namespace drape
