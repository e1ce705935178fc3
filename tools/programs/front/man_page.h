// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace drape {

// The manual page of a program (section 1, macros of man(7), ASCII) from its table (TableJson).
// `see_also`: other pages, "drape_fit(1), drape_report(1)". `body`: text of roff beside the
// options, before them.
std::string ManPage(const nlohmann::json& table, const std::string& see_also,
                    const std::string& body = "");

// Text as roff: backslashes, hyphens, leading dots and characters beside ASCII are escaped.
std::string RoffText(const std::string& text);

}  // namespace drape
