// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace drape {

// Writes what `cmake --install` puts beside the programs of `programs_folder`:
// man/man1/<program>.1 of each and of drapefit, and bash-completion/completions/<program>.
void WriteDocuments(const std::string& programs_folder, const std::string& out);

}  // namespace drape
