// SPDX-License-Identifier: Apache-2.0
#include "physics/util/text_format.h"

#include <cstdarg>
#include <cstdio>

namespace drape {

std::string Format(const char* format, ...) {
  char text[256];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

}  // namespace drape
