// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace drape {

// page/template.html as it was when the program was built.
extern const std::string_view kReportTemplate;

}  // namespace drape
