// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/inputs/files/file_readers.h"

namespace drape::attack {

std::vector<BadFile> MakeBadConfigs() {
  return {{"unknown key", "{\"stpes\": 3}"},
          {"number as text", "{\"threads\": \"3\"}"},
          {"text as number", "{\"out\": 3}"},
          {"null", "{\"out\": null}"},
          {"list for a value", "{\"out\": [\"a\"]}"},
          {"object for a value", "{\"out\": {\"a\": 1}}"},
          {"escape codes in a key", "{\"\\u001b[31m\": 3}"},
          {"escape codes in a value", "{\"law\": \"\\u001b[31m\\n\"}"},
          {"a long value", "{\"law\": \"" + std::string(5000, 'x') + "\"}"},
          {"config in a config", "{\"config\": \"c.json\"}"},
          {"help in a config", "{\"help\": true}"},
          {"a provenance that is a number", "{\"provenance\": 3}"},
          {"a provenance without options", "{\"provenance\": {}}"},
          {"a key of glog", "{\"v\": 1}"},
          {"a key twice", "{\"out\": \"a\", \"out\": \"b\"}"}};
}

std::vector<BadFile> MakeBadSummaries(const std::string& valid) {
  return MakeChanged(
      valid + "summary.json",
      {{"/provenance", "null"},
       {"/provenance", "[]"},
       {"/provenance/program", "\"drape_fit\""},
       {"/provenance/program", "3"},
       {"/provenance/program", ""},
       {"/provenance/working_directory", "3"},
       {"/provenance/options", ""},
       {"/provenance/options", "[]"},
       {"/provenance/options/no_such_option", "1"},
       {"/provenance/options/mesh", "3"},
       {"/provenance/options/mesh", "\"disc:1\"", true, "disc: 1 vertices"},
       {"/provenance/options/law", "\"\\u001b[31m\\n\""},
       {"/provenance/options/steps", "2.5"},
       {"/provenance/options/time_step", "-1"},
       {"/provenance/options/fabric", "\"../../../../etc/passwd\"", true, "etc/passwd"},
       {"/provenance/options/out", "3", false},  // each run has its own
       {"/provenance/given", "3"},
       {"/provenance/given", "[3]"},
       {"/provenance/build", "null", false},
       {"/provenance/inputs", ""},
       {"/provenance/inputs", "{}"},
       {"/provenance/inputs", "[]"},
       {"/provenance/inputs/0", "\"wool.json\""},
       {"/provenance/inputs/0/path", "\"no.json\""},
       {"/provenance/inputs/0/path", "\"/dev/zero\""},
       {"/provenance/inputs/0/path", "\"tmp\""},
       {"/provenance/inputs/0/path", "\"\\u001b[31m\\n\""},
       {"/provenance/inputs/0/bytes", "1"},
       {"/provenance/inputs/0/bytes", "-1"},
       {"/provenance/inputs/0/bytes", "1e300"},
       {"/provenance/inputs/0/sha256", "3"},
       {"/provenance/inputs/0/sha256", "\"x\""},
       {"/provenance/inputs/0/sha256", '"' + std::string(64, '0') + '"'}});
}

std::vector<BadFile> MakeBadPosteriors(const std::string& valid) {
  return MakeChanged(valid + "posterior/posterior.json",
                     {{"/format", "\"x\""},
                      {"/version", "1"},
                      {"/kind", "\"x\""},
                      {"/kind", "\"bdp\""},
                      {"/log_factors_on", "\"../../../../etc/passwd\""},
                      {"/names", "[]"},
                      {"/names/0", "\"x\""},
                      {"/names/0", "\"\\u001b[31m\\n\""},
                      {"/names/0", ""},
                      {"/mean", "[]"},
                      {"/mean/0", "null"},
                      {"/mean/0", "1000"},
                      {"/mean/0", "1e308"},
                      {"/mean/0", "-1e308"},
                      {"/prior_sd/0", "-1"},
                      {"/prior_sd/0", "0", false},
                      {"/prior_sd/0", "1e308", false},
                      {"/prior_sd", ""},
                      {"/covariance", "[]"},
                      {"/covariance", ""},
                      {"/covariance/0", ""},
                      {"/covariance/0/0", "-1"},
                      {"/covariance/0/0", "1e308", false},
                      {"/covariance/0/0", "1e6", false},
                      {"/covariance/0/1", "5"},
                      {"/covariance/1/0", "null"},
                      {"/element_sd", "[1]"}});
}

std::vector<BadFile> MakeBadSplits(const std::string& valid) {
  return MakeChanged(valid + "split.json", {{"/format", "\"x\""},
                                            {"/seed", "-1"},
                                            {"/seed", "1.5"},
                                            {"/seed", "18446744073709551616"},
                                            {"/train", "[]", false},
                                            {"/train", "{}"},
                                            {"/train", ""},
                                            {"/held_out", "[]", false},
                                            {"/train/0", "", false},
                                            {"/train/0", "[]"},
                                            {"/train/0", "1e308"},
                                            {"/train/0", "null"},
                                            {"/more", "1"}});
}

std::vector<BadFile> MakeBadAccuracyTables(const std::string& valid) {
  return MakeChanged(valid + "accuracy.json", {{"/format", "1"},
                                               {"/version", "0"},
                                               {"/made_on", ""},
                                               {"/made_on", "[]"},
                                               {"/fast_mm", "\"x\""},
                                               {"/fast_mm", "-1"},
                                               {"/fast_mm", "1e308", false},
                                               {"/rows", "[]"},
                                               {"/rows", "{}"},
                                               {"/rows/0", "1"},
                                               {"/rows/0/mesh", "\"disc:1\""},
                                               {"/rows/0/mesh", "5"},
                                               {"/rows/0/mesh", "\"../../../etc/passwd\""},
                                               {"/rows/0/mesh", "\"disc:99999999\""},
                                               {"/rows/0/solve", "\"static\""},
                                               {"/rows/0/solve", "\"\\u001b[31m\""},
                                               {"/rows/0/time_step", "0"},
                                               {"/rows/0/time_step", "-1"},
                                               {"/rows/0/time_step", "1e9"},
                                               {"/rows/0/time_step", "1e308"},
                                               {"/rows/0/steps", "-1"},
                                               {"/rows/0/steps", "1.5"},
                                               {"/rows/0/steps", "2000000000"},
                                               {"/rows/0/steps", "2147483648"},
                                               {"/rows/0/error_mm", "-1"},
                                               {"/rows/0/error_mm", "null"},
                                               {"/rows/0/cost", "-1"},
                                               {"/rows/0/cost", "\"x\""},
                                               {"/rows/0/more", "1"}});
}

std::vector<BadFile> MakeBadLabTests(const std::string& valid) {
  std::vector<BadFile> bad =
      MakeChanged(valid + "tensile.json", {{"/test", ""},
                                           {"/test", "\"x\""},
                                           {"/direction", "1e308"},
                                           {"/direction", "null"},
                                           {"/length", "0"},
                                           {"/length", "1e308"},
                                           {"/length", ""},
                                           {"/width", "-1"},
                                           {"/width", "1e-300"},
                                           {"/sigma", "0"},
                                           {"/sigma", "1e308", false},
                                           {"/sigma", "1e-308", false},
                                           {"/points", "[]"},
                                           {"/points", "{}"},
                                           {"/points/0/force", "-1"},
                                           {"/points/0/force", "1e308", false},
                                           {"/points/0/stretch", "0"},
                                           {"/points/0/stretch", "1e308"},
                                           {"/points/0/stretch", ""},
                                           {"/points/0/angle", "5"},
                                           {"/more", "1"}});
  const std::vector<BadFile> more =
      MakeChanged(valid + "cantilever.json", {{"/points/0/length", "0"},
                                              {"/points/0/length", "1e308"},
                                              {"/points/0/length", "1e-300", false},
                                              {"/points/0/angle", "91"},
                                              {"/points/0/angle", "-1"},
                                              {"/points/0/angle", "1e-300", false},
                                              {"/length", "1"}});
  bad.insert(bad.end(), more.begin(), more.end());
  return bad;
}

}  // namespace drape::attack
