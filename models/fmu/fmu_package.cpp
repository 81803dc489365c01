#include <sys/stat.h>
#include <zip.h>

#include <array>
#include <fstream>
#include <memory>

#include "engine/base/error.h"
#include "models/fmu/fmu_package_internal.h"

namespace lithe {
namespace {

namespace fs = std::filesystem;

constexpr zip_int64_t kMostFiles = 100'000;
constexpr std::uint64_t kMostBytes = std::uint64_t{4} << 30;

struct CloseArchive {
  void operator()(zip_t* archive) const { zip_discard(archive); }
};
struct CloseFile {
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};

/// Whether a name of an archive stays within the folder that it is unpacked into.
bool stays_inside(const std::string& name) {
  if (name.empty() || name.front() == '/' || name.find('\\') != std::string::npos ||
      name.find(':') != std::string::npos)
    return false;
  for (const fs::path& part : fs::path(name))
    if (part == "..") return false;
  return true;
}

bool is_link(zip_t* archive, zip_uint64_t index) {
  zip_uint8_t system = 0;
  zip_uint32_t attributes = 0;
  return zip_file_get_external_attributes(archive, index, 0, &system, &attributes) == 0 && system == ZIP_OPSYS_UNIX &&
         S_ISLNK(attributes >> 16);
}

}  // namespace

FmuPackage::FmuPackage(const std::string& path) : path_(path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) fail("there is no such file.", "give the path of an FMU.");
  unpack();
}

void FmuPackage::fail(const std::string& problem, const std::string& fix) const {
  throw FileError(problem, path_, fix);
}

void FmuPackage::unpack() {
  const std::string fix = "export the FMU again.";
  const std::unique_ptr<zip_t, CloseArchive> archive(zip_open(path_.c_str(), ZIP_RDONLY, nullptr));
  if (!archive) fail("the file is no zip archive, or damaged.", fix);
  const zip_int64_t count = zip_get_num_entries(archive.get(), 0);
  if (count > kMostFiles) fail("the archive has more than 100,000 files.", "no FMU has: give another file.");
  std::uint64_t stated = 0, all = 0;
  for (zip_uint64_t i = 0; i < static_cast<zip_uint64_t>(count); ++i)
    if (zip_stat_t entry; zip_stat_index(archive.get(), i, 0, &entry) == 0 && entry.valid & ZIP_STAT_SIZE)
      stated += entry.size;
  if (stated > kMostBytes) fail("the archive unpacks to more than 4 GiB.", "no FMU does: give another file.");
  for (zip_uint64_t i = 0; i < static_cast<zip_uint64_t>(count); ++i) {
    zip_stat_t entry;
    zip_stat_init(&entry);
    if (zip_stat_index(archive.get(), i, 0, &entry) != 0 || !(entry.valid & ZIP_STAT_NAME))
      fail("the archive's list of files is damaged.", fix);
    const std::string name = entry.name;
    if (!stays_inside(name) || is_link(archive.get(), i))
      fail("the archive's entry '" + name + "' leads out of its folder.", "do not use this file.");
    if (name.back() == '/') continue;
    const fs::path target = folder() / name;
    std::error_code error;
    fs::create_directories(target.parent_path(), error);
    std::ofstream out(target, std::ios::binary);
    if (error || !out) fail("'" + name + "' cannot be unpacked into " + folder().string() + ".", "free space there.");
    const std::unique_ptr<zip_file_t, CloseFile> file(zip_fopen_index(archive.get(), i, 0));
    if (!file) fail("'" + name + "' cannot be read: " + zip_strerror(archive.get()) + ".", fix);
    std::array<char, 65536> bytes;
    zip_int64_t read = 0;
    while ((read = zip_fread(file.get(), bytes.data(), bytes.size())) > 0) {
      all += static_cast<std::uint64_t>(read);
      if (all > kMostBytes) fail("the archive unpacks to more than 4 GiB.", "no FMU does: give another file.");
      if (!out.write(bytes.data(), read))
        fail("'" + name + "' cannot be unpacked into " + folder().string() + ".", "free space there.");
    }
    if (read < 0) fail("'" + name + "' is damaged.", fix);  // its checksum, too
  }
}

}  // namespace lithe
