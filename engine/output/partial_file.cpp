#include "engine/output/partial_file.h"

#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "engine/base/error.h"

namespace lithe {

namespace {

[[noreturn]] void throw_unwritable(const std::string& path, const std::error_code& why) {
  throw FileError("cannot write the file: " + why.message() + ".", path,
                  "choose a path in a folder you may write to, and check that the disk is not full.");
}

}  // namespace

// The process id keeps two runs that write the same file out of each other's way.
PartialFile::PartialFile(std::string path)
    : path_(std::move(path)), temporary_path_(path_ + ".partial-" + std::to_string(::getpid())) {
  std::error_code why;
  const auto kind = std::filesystem::status(path_, why).type();
  using enum std::filesystem::file_type;
  // A terminal, a pipe, /dev/null: nothing to rename.
  if (kind == character || kind == fifo || kind == socket || kind == block) temporary_path_ = path_;
  why.clear();
  const auto folder = std::filesystem::path(path_).parent_path();
  if (!folder.empty()) std::filesystem::create_directories(folder, why);
  if (why) throw_unwritable(path_, why);

  errno = 0;
  stream_.open(temporary_path_, std::ios::binary | std::ios::trunc);
  if (!stream_) throw_unwritable(path_, {errno, std::generic_category()});
}

PartialFile::~PartialFile() {
  // After commit() the temporary name is gone and this does nothing.
  stream_.close();
  if (temporary_path_ != path_) ::unlink(temporary_path_.c_str());  // allocates nothing: memory may have run out
}

void PartialFile::commit() {
  errno = 0;
  stream_.close();
  if (!stream_) throw_unwritable(path_, {errno ? errno : EIO, std::generic_category()});
  std::error_code why;
  if (temporary_path_ != path_) std::filesystem::rename(temporary_path_, path_, why);
  if (why) throw_unwritable(path_, why);
}

}  // namespace lithe
