#include "engine/output/hdf5_file.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "engine/base/error.h"
#include "engine/base/packed_texts.h"
#include "engine/output/hdf5_internal.h"
#include "engine/output/partial_file.h"

namespace lithe {
namespace {

constexpr const char* kFixRead = "write the file again; this one is damaged or cut short, or not of this kind.";

/// Of what a writer may be writing this moment: HDF5's own hundred, each after twice the time, take hours.
constexpr unsigned kReadAttempts = 10;

constexpr std::size_t kMemoryIncrement = 1 << 18;  // bytes, by which a file in memory grows

using Handle = Hdf5Handle;

/// Of what a data set holds, kept beside it: contiguous data have no checksum of HDF5's own. Four lanes of FNV-1a over
/// eight bytes at a time.
std::int64_t checksum(const void* values, size_t size) {
  constexpr std::uint64_t kPrime = 1099511628211ull;
  std::uint64_t lanes[4] = {14695981039346656037ull, 1, 2, size};
  const auto* bytes = static_cast<const unsigned char*>(values);
  std::uint64_t words[4];
  const auto mix = [](std::uint64_t lane, std::uint64_t word) {
    const std::uint64_t mixed = (lane ^ word) * kPrime;
    return mixed ^ (mixed >> 29);
  };
  for (; size >= sizeof words; size -= sizeof words, bytes += sizeof words) {
    std::memcpy(words, bytes, sizeof words);
    for (int k = 0; k < 4; ++k) lanes[k] = mix(lanes[k], words[k]);
  }
  for (; size > 0; --size, ++bytes) lanes[0] = mix(lanes[0], *bytes);
  std::uint64_t sum = 0;
  for (std::uint64_t lane : lanes) sum = mix(sum, lane);
  std::int64_t stored;
  std::memcpy(&stored, &sum, sizeof stored);
  return stored;
}

constexpr const char* kChecksum = "checksum";

size_t byte_count(hid_t type, const std::vector<hsize_t>& extent) {
  size_t bytes = H5Tget_size(type);
  for (hsize_t size : extent) bytes *= size;
  return bytes;
}

}  // namespace

// ---- writing ----

struct Hdf5Writer::Handles {
  /// Where HDF5's file in memory is left when it is closed.
  struct Image {
    std::size_t size = 0;  // of the file; what holds it may be larger
    std::vector<char> bytes;
  };

  /// HDF5 writes into memory, and what it wrote goes to disk as bytes: of a file that it could not flush it keeps a
  /// handle that crashes the program at its end. (H5Fget_file_image, of an open file, gives a header whose checksum is
  /// wrong.)
  static Hdf5Handle in_memory(Image& image) {
    Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    H5FD_file_image_callbacks_t calls{};
    calls.image_malloc = [](size_t size, H5FD_file_image_op_t, void*) { return std::malloc(size); };
    calls.image_memcpy = [](void* to, const void* from, size_t size, H5FD_file_image_op_t, void*) {
      return std::memcpy(to, from, size);
    };
    calls.image_realloc = [](void* old, size_t size, H5FD_file_image_op_t, void*) { return std::realloc(old, size); };
    calls.image_free = [](void* bytes, H5FD_file_image_op_t when, void* kept) -> herr_t {
      auto& to = *static_cast<Image*>(kept);
      try {
        const char* from = static_cast<const char*>(bytes);
        if (when == H5FD_FILE_IMAGE_OP_FILE_CLOSE) to.bytes.assign(from, from + to.size);
      } catch (const std::bad_alloc&) {  // HDF5 is C: the writer sees that nothing is there
      }
      std::free(bytes);
      return 0;
    };
    calls.udata_copy = [](void* kept) { return kept; };
    calls.udata_free = [](void*) -> herr_t { return 0; };
    calls.udata = &image;
    H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V110);
    H5Pset_fapl_core(access, kMemoryIncrement, /*backing_store=*/false);
    H5Pset_file_image_callbacks(access, &calls);
    return access;
  }

  explicit Handles(const std::string& path) : disk(path) {}
  PartialFile disk;
  Image image;
  Handle file, with_groups;

  [[noreturn]] void fail(const std::string& path, const std::string& name) const {
    throw FileError("cannot write '" + name + "' into the HDF5 file.", path,
                    "choose a path in a folder you may write to, and check that the disk is not full.");
  }
  void write(const std::string& path, const std::string& name, hid_t type, const std::vector<hsize_t>& extent,
             const void* values) const {
    const Handle space(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr), H5Sclose);
    const Handle set(H5Dcreate2(file, name.c_str(), type, space, with_groups, H5P_DEFAULT, H5P_DEFAULT), H5Dclose);
    const size_t bytes = byte_count(type, extent);
    if (!space.valid() || !set.valid() || (bytes > 0 && H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0))
      fail(path, name);
    const std::int64_t sum = checksum(values, bytes);
    const Handle scalar(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle place(H5Acreate2(set, kChecksum, H5T_NATIVE_INT64, scalar, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    if (!place.valid() || H5Awrite(place, H5T_NATIVE_INT64, &sum) < 0) fail(path, name);
  }
};

Hdf5Writer::Hdf5Writer(std::string path) : path_(std::move(path)), handles_(std::make_unique<Handles>(path_)) {
  silence_hdf5();
  const Handle access = Handles::in_memory(handles_->image);
  const std::string& name = handles_->disk.temporary_path();  // unique among the files that HDF5 has open
  handles_->file = Handle(H5Fcreate(name.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose);
  handles_->with_groups = Handle(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(handles_->with_groups, 1);
  if (!handles_->file.valid()) handles_->fail(path_, "/");
}

Hdf5Writer::~Hdf5Writer() = default;

void Hdf5Writer::write(const std::string& name, const Eigen::Ref<const MatrixX>& matrix) {
  const MatrixX copy = matrix.outerStride() == matrix.rows() ? MatrixX() : MatrixX(matrix);
  const double* values = copy.size() > 0 ? copy.data() : matrix.data();
  handles_->write(path_, name, H5T_NATIVE_DOUBLE,
                  {static_cast<hsize_t>(matrix.cols()), static_cast<hsize_t>(matrix.rows())}, values);
}

void Hdf5Writer::write(const std::string& name, const std::vector<int>& integers) {
  handles_->write(path_, name, H5T_NATIVE_INT, {integers.size()}, integers.data());
}

void Hdf5Writer::write(const std::string& name, const std::vector<double>& numbers) {
  handles_->write(path_, name, H5T_NATIVE_DOUBLE, {numbers.size()}, numbers.data());
}

void Hdf5Writer::write(const std::string& name, const std::string& text) {
  handles_->write(path_, name, H5T_NATIVE_CHAR, {text.size()}, text.data());
}

void Hdf5Writer::write(const std::string& name, const std::vector<std::string>& texts) { write(name, packed(texts)); }

void Hdf5Writer::attribute(const std::string& of, const std::string& name, const std::string& text) {
  const Handle object(H5Oopen(handles_->file, of.c_str(), H5P_DEFAULT), H5Oclose);
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
  H5Tset_size(type, text.size() + 1);
  const Handle place(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!object.valid() || !place.valid() || H5Awrite(place, type, text.c_str()) < 0) handles_->fail(path_, name);
}

void Hdf5Writer::attribute(const std::string& of, const std::string& name, std::int64_t number) {
  const Handle object(H5Oopen(handles_->file, of.c_str(), H5P_DEFAULT), H5Oclose);
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle place(H5Acreate2(object, name.c_str(), H5T_NATIVE_INT64, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!object.valid() || !place.valid() || H5Awrite(place, H5T_NATIVE_INT64, &number) < 0) handles_->fail(path_, name);
}

void Hdf5Writer::commit() {
  Handles::Image& image = handles_->image;
  const ssize_t size = H5Fflush(handles_->file, H5F_SCOPE_GLOBAL) < 0
                           ? -1
                           : H5Fget_file_image(handles_->file, nullptr, 0);  // of the file, not of its memory
  if (size <= 0) handles_->fail(path_, "/");
  image.size = static_cast<std::size_t>(size);
  if (!handles_->file.reset() || image.bytes.size() != image.size) handles_->fail(path_, "/");
  handles_->disk.stream().write(image.bytes.data(), size);
  handles_->disk.commit();
}

// ---- reading ----

struct Hdf5Reader::Handles {
  Handle file;
};

Hdf5Reader::Hdf5Reader(std::string path) : path_(std::move(path)), handles_(std::make_unique<Handles>()) {
  silence_hdf5();
  std::error_code why;
  if (!std::filesystem::is_regular_file(path_, why))
    throw FileError("there is no such file.", path_, "check the path; relative ones start at the working folder.");
  handles_->file = Handle(H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!handles_->file.valid()) {  // of a run that was killed, or goes on: hdf5_series.h
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    H5Pset_metadata_read_attempts(access, kReadAttempts);
    handles_->file = Handle(H5Fopen(path_.c_str(), H5F_ACC_RDONLY | H5F_ACC_SWMR_READ, access), H5Fclose);
  }
  if (!handles_->file.valid()) throw FileError("this is not an HDF5 file, or it is cut short.", path_, kFixRead);
}

Hdf5Reader::~Hdf5Reader() = default;

void Hdf5Reader::refuse(const std::string& name, const std::string& problem) const {
  throw FileError("'" + name + "' " + problem + ".", path_, kFixRead);
}

bool Hdf5Reader::has(const std::string& name) const {
  // H5Lexists wants every group on the way to exist.
  for (size_t slash = name.find('/', 1); slash != std::string::npos; slash = name.find('/', slash + 1))
    if (H5Lexists(handles_->file, name.substr(0, slash).c_str(), H5P_DEFAULT) <= 0) return false;
  return H5Lexists(handles_->file, name.c_str(), H5P_DEFAULT) > 0;
}

namespace {

/// A data set that has been opened and measured.
struct OpenSet {
  Handle set;
  std::vector<hsize_t> extent;
};

/// Whether all of a data set lies within the file, which may be cut short: HDF5 takes what is beyond the end for zeros.
bool is_whole(const OpenSet& open, std::uintmax_t file_size) {
  const auto is_there = [&](haddr_t first, hsize_t size) { return first <= file_size && size <= file_size - first; };
  const Handle layout(H5Dget_create_plist(open.set), H5Pclose);
  if (H5Pget_layout(layout) != H5D_CHUNKED) {
    const haddr_t first = H5Dget_offset(open.set);
    return first == HADDR_UNDEF || is_there(first, H5Dget_storage_size(open.set));
  }
  const size_t dimensions = open.extent.size();
  std::vector<hsize_t> chunk(dimensions), at(dimensions, 0);
  if (H5Pget_chunk(layout, static_cast<int>(dimensions), chunk.data()) < 0) return false;
  for (size_t k = 0; k < dimensions;) {
    unsigned filters = 0;
    haddr_t first = HADDR_UNDEF;
    hsize_t size = 0;
    if (H5Dget_chunk_info_by_coord(open.set, at.data(), &filters, &first, &size) < 0) return false;
    if (!is_there(first, size)) return false;  // HADDR_UNDEF, too, is beyond any file
    for (k = 0; k < dimensions && (at[k] += std::max<hsize_t>(chunk[k], 1)) >= open.extent[k]; ++k) at[k] = 0;
  }
  return true;
}

OpenSet open_set(const Hdf5Reader& reader, hid_t file, const std::string& name, H5T_class_t kind, size_t dimensions) {
  OpenSet open{Handle(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose), {}};
  if (!open.set.valid()) reader.refuse(name, "is missing");
  const Handle type(H5Dget_type(open.set), H5Tclose), space(H5Dget_space(open.set), H5Sclose);
  if (!type.valid() || H5Tget_class(type) != kind) reader.refuse(name, "holds another kind of values");
  if (!space.valid() || H5Sget_simple_extent_ndims(space) != static_cast<int>(dimensions))
    reader.refuse(name, "has another number of dimensions");
  open.extent.resize(dimensions);
  H5Sget_simple_extent_dims(space, open.extent.data(), nullptr);
  // A damaged header may promise more than any file holds: believe what is stored.
  const hsize_t stored = H5Dget_storage_size(open.set);
  hsize_t room = stored / std::max<hsize_t>(H5Tget_size(type), 1);
  if (std::find(open.extent.begin(), open.extent.end(), 0) != open.extent.end()) return open;
  for (hsize_t size : open.extent) room /= size;
  std::error_code why;
  if (room == 0 || !is_whole(open, std::filesystem::file_size(reader.path(), why)))
    reader.refuse(name, "is larger than what the file holds");
  return open;
}

void read_all(const Hdf5Reader& reader, const OpenSet& open, const std::string& name, hid_t type, void* values) {
  const size_t bytes = byte_count(type, open.extent);
  if (bytes > 0 && H5Dread(open.set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0)
    reader.refuse(name, "cannot be read");
  if (H5Aexists(open.set, kChecksum) <= 0) return;  // written by another program
  std::int64_t expected = 0;
  const Handle place(H5Aopen(open.set, kChecksum, H5P_DEFAULT), H5Aclose);
  if (H5Aread(place, H5T_NATIVE_INT64, &expected) < 0 || expected != checksum(values, bytes))
    reader.refuse(name, "is not what was written: its checksum differs");
}

template <typename Value>
std::vector<Value> read_vector(const Hdf5Reader& reader, hid_t file, const std::string& name, H5T_class_t kind,
                               hid_t type, std::int64_t size) {
  const OpenSet open = open_set(reader, file, name, kind, 1);
  if (size != Hdf5Reader::kAny && open.extent[0] != static_cast<hsize_t>(size))
    reader.refuse(name, "has " + std::to_string(open.extent[0]) + " entries instead of " + std::to_string(size));
  std::vector<Value> values(open.extent[0]);
  read_all(reader, open, name, type, values.data());
  return values;
}

}  // namespace

MatrixX Hdf5Reader::matrix(const std::string& name, std::int64_t rows, std::int64_t columns) const {
  const OpenSet open = open_set(*this, handles_->file, name, H5T_FLOAT, 2);
  const hsize_t found_rows = open.extent[1], found_columns = open.extent[0];
  if ((rows != kAny && found_rows != static_cast<hsize_t>(rows)) ||
      (columns != kAny && found_columns != static_cast<hsize_t>(columns)))
    refuse(name, "is " + std::to_string(found_rows) + " x " + std::to_string(found_columns) + " instead of " +
                     (rows == kAny ? "any" : std::to_string(rows)) + " x " +
                     (columns == kAny ? "any" : std::to_string(columns)));
  MatrixX values(static_cast<Eigen::Index>(found_rows), static_cast<Eigen::Index>(found_columns));
  read_all(*this, open, name, H5T_NATIVE_DOUBLE, values.data());
  return values;
}

std::vector<int> Hdf5Reader::integers(const std::string& name, std::int64_t size) const {
  return read_vector<int>(*this, handles_->file, name, H5T_INTEGER, H5T_NATIVE_INT, size);
}

std::vector<double> Hdf5Reader::numbers(const std::string& name, std::int64_t size) const {
  return read_vector<double>(*this, handles_->file, name, H5T_FLOAT, H5T_NATIVE_DOUBLE, size);
}

std::string Hdf5Reader::text(const std::string& name) const {
  const auto bytes = read_vector<char>(*this, handles_->file, name, H5T_INTEGER, H5T_NATIVE_CHAR, kAny);
  return {bytes.begin(), bytes.end()};
}

std::vector<std::string> Hdf5Reader::texts(const std::string& name) const {
  auto found = unpacked(text(name));
  if (!found) refuse(name, "is a list of texts whose last one is not closed");
  return *std::move(found);
}

std::string Hdf5Reader::text_attribute(const std::string& of, const std::string& name) const {
  const Handle place(H5Aopen_by_name(handles_->file, of.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!place.valid()) refuse(of, "lacks the attribute " + name);
  const Handle type(H5Aget_type(place), H5Tclose);
  if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) > 0 || H5Tget_size(type) > 100000)
    refuse(of, "has an attribute " + name + " that is not text");
  std::vector<char> bytes(H5Tget_size(type) + 1, '\0');
  if (H5Aread(place, type, bytes.data()) < 0) refuse(of, "has an attribute " + name + " that cannot be read");
  return bytes.data();
}

std::int64_t Hdf5Reader::number_attribute(const std::string& of, const std::string& name) const {
  const Handle place(H5Aopen_by_name(handles_->file, of.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  std::int64_t number = 0;
  if (!place.valid() || H5Aread(place, H5T_NATIVE_INT64, &number) < 0) refuse(of, "lacks the attribute " + name);
  return number;
}

}  // namespace lithe
