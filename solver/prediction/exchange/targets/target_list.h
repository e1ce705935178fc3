// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "solver/prediction/exchange/targets/export_material.h"

namespace drape {

// Internal to this folder: one function for each target.

ExportedMaterial ExportArcsim(const ExchangeRecord& record);
ExportedMaterial ExportClo(const ExchangeRecord& record);
ExportedMaterial ExportNewton(const ExchangeRecord& record, IsotropicChoice keep);
ExportedMaterial ExportStyle3d(const ExchangeRecord& record);
ExportedMaterial ExportPpf(const ExchangeRecord& record);
ExportedMaterial ExportBlender(const ExchangeRecord& record);
ExportedMaterial ExportUnreal(const ExchangeRecord& record);
ExportedMaterial ExportU3m(const ExchangeRecord& record);
ExportedMaterial ExportUsda(const ExchangeRecord& record);
ExportedMaterial ExportJson(const ExchangeRecord& record);

// The shortest text that reads back as this number.
std::string NumberText(double value);
// The name of the fabric as text between quotes in JSON, TOML, Python and USD.
std::string QuotedText(const std::string& text);

inline constexpr char kLosesTables[] =
    "the change of stiffness with strain and curvature: one number for each direction is left";
inline constexpr char kLosesCoupling[] = "c12, the coupling of the two thread directions";
inline constexpr char kLosesUncertainty[] = "the standard deviations of the posterior";

}  // namespace drape
