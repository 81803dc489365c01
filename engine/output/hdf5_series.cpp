#include "engine/output/hdf5_series.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <system_error>

#include "engine/base/error.h"
#include "engine/base/packed_texts.h"
#include "engine/output/hdf5_internal.h"

namespace lithe {
namespace {

constexpr hsize_t kChunkNumbers = 8192;  // 64 KiB, or one row if that is more

struct GrowingSet {
  Hdf5Handle set;
  hsize_t width = 0, rows = 0;
};

}  // namespace

struct Hdf5Series::Handles {
  std::string temporary;
  Hdf5Handle file;
  std::map<std::string, GrowingSet> sets;
  bool begun = false;
};

void Hdf5Series::fail(const std::string& name) const {
  throw FileError("cannot write '" + name + "' into the HDF5 file.", path_,
                  "choose a path in a folder you may write to, and check that the disk is not full.");
}

Hdf5Series::Hdf5Series(std::string path) : path_(std::move(path)), handles_(std::make_unique<Handles>()) {
  silence_hdf5();
  handles_->temporary = path_ + ".partial-" + std::to_string(::getpid());
  std::error_code why;
  const auto folder = std::filesystem::path(path_).parent_path();
  if (!folder.empty()) std::filesystem::create_directories(folder, why);
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110);
  handles_->file = Hdf5Handle(H5Fcreate(handles_->temporary.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose);
  if (!handles_->file.valid()) fail("/");
}

Hdf5Series::~Hdf5Series() {
  handles_->sets.clear();
  handles_->file.reset();
  ::unlink(handles_->temporary.c_str());  // gone already after begin()
}

void Hdf5Series::write(const std::string& name, std::int64_t type, const std::vector<std::uint64_t>& extent,
                       const void* values) {
  const std::vector<hsize_t> sizes(extent.begin(), extent.end());
  const Hdf5Handle space(H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr), H5Sclose);
  const Hdf5Handle set(H5Dcreate2(handles_->file, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                       H5Dclose);
  const bool empty = std::find(sizes.begin(), sizes.end(), 0) != sizes.end();
  if (!set.valid() || (!empty && H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0)) fail(name);
}

void Hdf5Series::write(const std::string& name, const MatrixX& matrix) {
  write(name, H5T_NATIVE_DOUBLE, {static_cast<std::uint64_t>(matrix.cols()), static_cast<std::uint64_t>(matrix.rows())},
        matrix.data());
}

void Hdf5Series::write(const std::string& name, const std::vector<int>& integers) {
  write(name, H5T_NATIVE_INT, {integers.size()}, integers.data());
}

void Hdf5Series::write(const std::string& name, const std::vector<std::string>& texts) {
  const std::string bytes = packed(texts);
  write(name, H5T_NATIVE_CHAR, {bytes.size()}, bytes.data());
}

void Hdf5Series::attribute(const std::string& of, const std::string& name, const std::string& text) {
  const auto growing = handles_->sets.find(of);
  const Hdf5Handle opened(
      growing == handles_->sets.end() ? H5Oopen(handles_->file, of.c_str(), H5P_DEFAULT) : H5I_INVALID_HID, H5Oclose);
  const hid_t object = growing == handles_->sets.end() ? hid_t(opened) : hid_t(growing->second.set);
  const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
  H5Tset_size(type, text.size() + 1);
  const Hdf5Handle place(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!place.valid() || H5Awrite(place, type, text.c_str()) < 0) fail(of + ", " + name);
}

void Hdf5Series::add(const std::string& name, int width) {
  GrowingSet& grown = handles_->sets[name];
  grown.width = static_cast<hsize_t>(width);
  const hsize_t none[] = {0, grown.width}, any[] = {H5S_UNLIMITED, grown.width};
  const hsize_t chunk[] = {std::max<hsize_t>(1, kChunkNumbers / std::max<hsize_t>(1, grown.width)), grown.width};
  const Hdf5Handle space(H5Screate_simple(2, none, any), H5Sclose), made(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_chunk(made, 2, chunk);
  grown.set = Hdf5Handle(
      H5Dcreate2(handles_->file, name.c_str(), H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, made, H5P_DEFAULT), H5Dclose);
  if (!grown.set.valid()) fail(name);
}

void Hdf5Series::begin() {
  if (H5Fstart_swmr_write(handles_->file) < 0) fail("/");
  std::error_code why;
  std::filesystem::rename(handles_->temporary, path_, why);
  if (why) fail("/");
  handles_->begun = true;
}

void Hdf5Series::append(const std::string& name, ConstVectorRef row) {
  const auto found = handles_->sets.find(name);
  if (found == handles_->sets.end() || found->second.width != static_cast<hsize_t>(row.size()))
    throw SceneError("a row of " + std::to_string(row.size()) + " numbers for '" + name + "'", path_,
                     "add() the data set with that width before rows are appended");
  GrowingSet& grown = found->second;
  const hsize_t from[] = {grown.rows, 0}, one[] = {1, grown.width}, size[] = {grown.rows + 1, grown.width};
  if (H5Dset_extent(grown.set, size) < 0) fail(name);
  const Hdf5Handle file_space(H5Dget_space(grown.set), H5Sclose),
      row_space(H5Screate_simple(2, one, nullptr), H5Sclose);
  if (H5Sselect_hyperslab(file_space, H5S_SELECT_SET, from, nullptr, one, nullptr) < 0 ||
      H5Dwrite(grown.set, H5T_NATIVE_DOUBLE, row_space, file_space, H5P_DEFAULT, row.data()) < 0)
    fail(name);
  ++grown.rows;
}

void Hdf5Series::flush() {
  for (auto& [name, grown] : handles_->sets)
    if (H5Dflush(grown.set) < 0) fail(name);
}

}  // namespace lithe
