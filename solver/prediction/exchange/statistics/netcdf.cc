// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/statistics/netcdf.h"

#include <dlfcn.h>
#include <glog/logging.h>
#include <netcdf.h>

#include <map>
#include <numeric>

#include "physics/util/errors.h"

namespace drape {
namespace {

// libnetcdf, loaded where a file is written: it brings 50 MB of other libraries, which a program
// that writes none should not need, nor a bundle hold.
class Library {
 public:
  static const Library* Get() {
    static const Library library;
    return library.handle_ != nullptr ? &library : nullptr;
  }
  template <class Function>
  Function* Find(const char* name) const {
    return reinterpret_cast<Function*>(CHECK_NOTNULL(dlsym(handle_, name)));
  }

 private:
  void* handle_ = dlopen(DRAPE_NETCDF_SONAME, RTLD_NOW | RTLD_LOCAL);
};
// The function of that name in the library, which is there.
#define DRAPE_NETCDF(name) (*Library::Get()->Find<decltype(name)>(#name))

// One open file, closed at the end of its scope.
class File {
 public:
  explicit File(const std::string& path) : path_(path) {
    Check(DRAPE_NETCDF(nc_create)(path.c_str(), NC_NETCDF4 | NC_CLOBBER, &id_));
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  ~File() {
    if (open_) DRAPE_NETCDF(nc_close)(id_);
  }

  void Check(int status) const {
    if (status != NC_NOERR)
      throw InputError(path_,
                       std::string("cannot be written: ") + DRAPE_NETCDF(nc_strerror)(status));
  }
  void Close() {
    open_ = false;
    Check(DRAPE_NETCDF(nc_close)(id_));
  }
  int id() const { return id_; }

  void PutAttributes(int group, int variable, const NetcdfAttributes& attributes) const {
    for (const auto& [name, text] : attributes)
      Check(
          DRAPE_NETCDF(nc_put_att_text)(group, variable, name.c_str(), text.size(), text.c_str()));
  }

  void PutCoordinate(int group, const NetcdfDimension& dimension, int dimension_id) const {
    int variable = 0;
    const bool labelled = !dimension.labels.empty(), numbered = !dimension.numbers.empty();
    Check(DRAPE_NETCDF(nc_def_var)(group, dimension.name.c_str(),
                                   labelled   ? NC_STRING
                                   : numbered ? NC_DOUBLE
                                              : NC_INT64,
                                   1, &dimension_id, &variable));
    if (numbered) {
      CHECK_EQ(static_cast<int>(dimension.numbers.size()), dimension.size) << dimension.name;
      PutAttributes(group, variable, {{"units", dimension.units}});
      return Check(DRAPE_NETCDF(nc_put_var_double)(group, variable, dimension.numbers.data()));
    }
    if (labelled) {
      CHECK_EQ(static_cast<int>(dimension.labels.size()), dimension.size) << dimension.name;
      std::vector<const char*> labels;
      for (const std::string& label : dimension.labels) labels.push_back(label.c_str());
      Check(DRAPE_NETCDF(nc_put_var_string)(group, variable, labels.data()));
      return;
    }
    std::vector<long long> numbers(dimension.size);
    std::iota(numbers.begin(), numbers.end(), 0LL);
    Check(DRAPE_NETCDF(nc_put_var_longlong)(group, variable, numbers.data()));
  }

  void PutVariable(int group, const NetcdfVariable& variable,
                   const std::map<std::string, std::pair<int, int>>& dimensions) const {
    std::vector<int> ids;
    size_t size = 1;
    for (const std::string& name : variable.dimensions) {
      const auto& [id, length] = dimensions.at(name);
      ids.push_back(id);
      size *= static_cast<size_t>(length);
    }
    CHECK_EQ(size, variable.values.size()) << variable.name;
    int id = 0;
    Check(DRAPE_NETCDF(nc_def_var)(group, variable.name.c_str(), NC_DOUBLE,
                                   static_cast<int>(ids.size()), ids.data(), &id));
    PutAttributes(group, id, {{"units", variable.units}, {"long_name", variable.long_name}});
    Check(DRAPE_NETCDF(nc_put_var_double)(group, id, variable.values.data()));
  }

  void PutGroup(const NetcdfGroup& group) const {
    int id = 0;
    Check(DRAPE_NETCDF(nc_def_grp)(id_, group.name.c_str(), &id));
    std::map<std::string, std::pair<int, int>> dimensions;
    for (const NetcdfDimension& dimension : group.dimensions) {
      int dimension_id = 0;
      Check(DRAPE_NETCDF(nc_def_dim)(id, dimension.name.c_str(),
                                     static_cast<size_t>(dimension.size), &dimension_id));
      PutCoordinate(id, dimension, dimension_id);
      dimensions[dimension.name] = {dimension_id, dimension.size};
    }
    for (const NetcdfVariable& variable : group.variables) PutVariable(id, variable, dimensions);
    PutAttributes(id, NC_GLOBAL, group.attributes);
  }

 private:
  std::string path_;
  int id_ = 0;
  bool open_ = true;
};

}  // namespace

bool HasNetcdf() { return Library::Get() != nullptr; }

void WriteNetcdf(const std::string& path, const std::vector<NetcdfGroup>& groups,
                 const NetcdfAttributes& attributes) {
  if (!HasNetcdf())
    throw InputError(path,
                     "cannot be written: " DRAPE_NETCDF_SONAME
                     " is not installed (Debian: libnetcdf19), expected csv, which needs none");
  File file(path);
  file.PutAttributes(file.id(), NC_GLOBAL, attributes);
  for (const NetcdfGroup& group : groups) file.PutGroup(group);
  file.Close();
}

}  // namespace drape
