#include "host/cli/case_claims.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "host/errors/error.hpp"

namespace umov::cli {

CaseClaim::~CaseClaim() {
  if (file_ >= 0) close(file_);
}

CaseClaims::CaseClaims(const std::filesystem::path& folder) : path_(folder / ".claims") {
  claim(0);
}

std::optional<CaseClaim> CaseClaims::claim(std::size_t number) const {
  const int file = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (file < 0) {
    throw Error({path_.string()}, std::string("cannot be opened: ") + std::strerror(errno),
                "check space and permissions of the folder");
  }
  CaseClaim claim(file);
  struct flock range = {};
  range.l_type = F_WRLCK;
  range.l_whence = SEEK_SET;
  range.l_start = static_cast<off_t>(number);
  range.l_len = 1;
  // A lock of this open file, not of the process: threads exclude each other too.
  if (fcntl(file, F_OFD_SETLK, &range) == 0) return claim;
  if (errno == EAGAIN || errno == EACCES) return std::nullopt;
  throw Error({path_.string()}, std::string("cannot be locked: ") + std::strerror(errno),
              "put the answers on a file system that has locks, or run one process without mpirun "
              "and with --threads 1 on a local disk");
}

}  // namespace umov::cli
