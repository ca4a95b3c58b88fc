#include "host/formats/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "host/errors/error.hpp"

namespace umov::formats {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what, int code) {
  throw Error(Place{path.string()}, what + ": " + std::strerror(code),
              "check that the folder exists, is writable and has space left");
}

void sync_file(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) fail(path, "cannot open for syncing", errno);
  const int result = ::fsync(descriptor);
  const int code = errno;
  ::close(descriptor);
  if (result != 0) fail(path, "cannot sync", code);
}

}  // namespace

void sync_folder_of(const std::filesystem::path& path) {
  std::filesystem::path folder = path.parent_path();
  if (folder.empty()) folder = ".";
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) fail(folder, "cannot open the folder for syncing", errno);
  const int result = ::fsync(descriptor);
  const int code = errno;
  ::close(descriptor);
  // Some network file systems cannot sync folders and say EINVAL; the rename itself was done.
  if (result != 0 && code != EINVAL) fail(folder, "cannot sync the folder", code);
}

ReplacedFile::ReplacedFile(std::filesystem::path target)
    : target_(std::move(target)),
      temporary_(target_.string() + ".part-" + std::to_string(::getpid())) {
  std::error_code ignored;
  if (std::filesystem::is_directory(target_, ignored))
    throw Error(Place{target_.string()}, "is a folder", "name a file to write");
  std::filesystem::path folder = target_.parent_path();
  if (!folder.empty() && !std::filesystem::is_directory(folder, ignored))
    throw Error(Place{target_.string()}, "the folder does not exist", "create the folder first");
}

ReplacedFile::~ReplacedFile() {
  if (committed_) return;
  std::error_code ignored;
  std::filesystem::remove(temporary_, ignored);
}

void ReplacedFile::commit() {
  sync_file(temporary_);
  std::error_code code;
  std::filesystem::rename(temporary_, target_, code);
  if (code) fail(target_, "cannot put the new file in place", code.value());
  committed_ = true;
  sync_folder_of(target_);
}

void replace_file(const std::filesystem::path& target, std::string_view bytes) {
  ReplacedFile file(target);
  std::ofstream out(file.temporary(), std::ios::binary | std::ios::trunc);
  if (!out) fail(target, "cannot write", errno);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) fail(target, "cannot write", errno);
  file.commit();
}

void require_readable_size(std::size_t bytes, const std::string& name, std::size_t most) {
  if (bytes > most)
    throw Error(Place{name},
                fmt::format("is larger than {:.4g} MB, the most that is read",
                            static_cast<double>(most) * 1e-6),
                "is it the file you mean? a larger one has to be split");
}

std::string read_whole_file(const std::filesystem::path& path, std::size_t most) {
  std::error_code ignored;
  const auto status = std::filesystem::status(path, ignored);
  if (std::filesystem::is_directory(status))
    throw Error(Place{path.string()}, "is a folder", "name a file");
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status) &&
      !std::filesystem::is_fifo(status))
    throw Error(Place{path.string()}, "is a device or socket, not a file", "name a file or pipe");
  if (std::filesystem::is_regular_file(status)) {
    // What the size says may change, so that the reading below counts too.
    const auto size = std::filesystem::file_size(path, ignored);
    if (!ignored) require_readable_size(size, path.string(), most);
  }
  std::ifstream in(path, std::ios::binary);
  if (!in)
    throw Error(Place{path.string()}, std::string("cannot open: ") + std::strerror(errno),
                "check the path and its permissions");
  std::string bytes;
  // Grow with what is really there: the size a special file declares means nothing.
  std::string chunk(1 << 20, '\0');
  while (in) {
    in.read(chunk.data(), static_cast<std::streamsize>(chunk.size()));
    bytes.append(chunk.data(), static_cast<std::size_t>(in.gcount()));
    require_readable_size(bytes.size(), path.string(), most);
  }
  if (in.bad())
    throw Error(Place{path.string()}, std::string("cannot read: ") + std::strerror(errno),
                "check the medium");
  return bytes;
}

}  // namespace umov::formats
