// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include "physics/util/atomic_file.h"

// The same as EXPECT_INPUT_ERROR for an IoError.
#define EXPECT_IO_ERROR(statement, text)                   \
  try {                                                    \
    statement;                                             \
    ADD_FAILURE() << "no IoError, expected: " << (text);   \
  } catch (const ::drape::IoError& error) {                \
    EXPECT_THAT(error.what(), ::testing::HasSubstr(text)); \
  }
