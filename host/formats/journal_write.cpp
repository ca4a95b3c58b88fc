// Appending to a journal: write(2) for order, fdatasync(2) before anything is promised.
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/journal.hpp"
#include "host/formats/journal_records.hpp"

namespace umov::formats {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what, int code,
                       const std::string& remedy) {
  throw Error(Place{path.string()}, what + ": " + std::strerror(code), remedy);
}

void lock(int descriptor, const std::filesystem::path& path) {
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) return;
  if (errno == EWOULDBLOCK)
    throw Error(Place{path.string()}, "another program is writing this journal",
                "wait for it to end, or end it");
  fail(path, "cannot lock the journal", errno, "use a local folder");
}

/// False with errno set where not all bytes could be written.
bool write_all(int descriptor, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return false;
    }
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

/// Gives the finished temporary file its name unless that is taken.
void publish(const std::filesystem::path& temporary, const std::filesystem::path& path) {
  if (::link(temporary.c_str(), path.c_str()) == 0) {
    ::unlink(temporary.c_str());
    return;
  }
  int code = errno;
  if (code == EPERM || code == EOPNOTSUPP || code == ENOSYS) {
    // A file system without hard links: the test for existence is then a moment apart.
    if (std::filesystem::exists(path)) {
      code = EEXIST;
    } else if (::rename(temporary.c_str(), path.c_str()) == 0) {
      return;
    } else {
      code = errno;
    }
  }
  ::unlink(temporary.c_str());
  fail(path, "cannot create the journal", code,
       code == EEXIST ? "resume that scan, or delete its journal" : "check the folder");
}

}  // namespace

JournalWriter::JournalWriter(int descriptor, std::filesystem::path path)
    : descriptor_(descriptor), path_(std::move(path)) {}

JournalWriter::JournalWriter(JournalWriter&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      failed_(other.failed_),
      path_(std::move(other.path_)) {}

JournalWriter& JournalWriter::operator=(JournalWriter&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(failed_, other.failed_);
  std::swap(path_, other.path_);
  return *this;
}

JournalWriter::~JournalWriter() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

JournalWriter JournalWriter::create(const std::filesystem::path& path,
                                    const JournalHeader& header) {
  // Written under another name first: a journal that exists has a whole header.
  const std::filesystem::path temporary = path.string() + ".part-" + std::to_string(::getpid());
  const int descriptor =
      ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, 0644);
  if (descriptor < 0)
    fail(path, "cannot create the journal", errno, "check that the folder exists and is writable");
  JournalWriter writer(descriptor, path);
  try {
    lock(descriptor, path);
    Bytes bytes;
    for (const char c : journal_signature) bytes.push_back(static_cast<std::byte>(c));
    put_frame(bytes, encode_header(header));
    if (!write_all(descriptor, bytes) || ::fsync(descriptor) != 0)
      fail(path, "cannot write the journal", errno, "free some space on the disk");
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
  publish(temporary, path);
  sync_folder_of(path);
  return writer;
}

JournalWriter JournalWriter::resume(const std::filesystem::path& path, Journal& recovered) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_APPEND | O_CLOEXEC);
  if (descriptor < 0)
    fail(path, "cannot open the journal", errno, "check the path and its permissions");
  JournalWriter writer(descriptor, path);
  lock(descriptor, path);
  recovered = read_journal(path);
  if (recovered.torn_bytes > 0 &&
      (::ftruncate(descriptor, static_cast<off_t>(recovered.valid_bytes)) != 0 ||
       ::fsync(descriptor) != 0))
    fail(path, "cannot cut the torn end off the journal", errno, "check the disk");
  return writer;
}

void JournalWriter::append(std::span<const ScanRecord> records) {
  if (descriptor_ < 0 || failed_)
    throw Error(Place{path_.string()}, "the journal cannot be written after a failure",
                "resume the scan when the cause is removed");
  Bytes bytes;
  bytes.reserve(records.size() * (frame_overhead + record_payload_size));
  Bytes payload;
  for (const ScanRecord& record : records) {
    payload.clear();
    put_record(payload, record);
    put_frame(bytes, payload);
  }
  if (!write_all(descriptor_, bytes)) {
    const int code = errno;
    failed_ = true;
    fail(path_, "cannot write the journal", code, "free some space on the disk, then resume");
  }
}

void JournalWriter::sync() {
  if (failed_)
    throw Error(Place{path_.string()}, "the journal cannot be synced after a failure",
                "resume the scan when the cause is removed");
  if (::fdatasync(descriptor_) != 0) {
    const int code = errno;
    // The kernel may have dropped the pages: what was appended since is not to be relied upon.
    failed_ = true;
    fail(path_, "cannot sync the journal", code, "check the disk, then resume");
  }
}

}  // namespace umov::formats
