// Test vectors: example messages as frames in hexadecimal, for both ends and other implementers.
#pragma once

#include <string>
#include <vector>

namespace umov::protocol {

/// A text file of vectors.
struct VectorFile {
  std::string name;  ///< such as "record.txt"
  std::string text;
};

/// One file a message with its values, payload and frame: all fields at their least, all at their
/// greatest, and three with mixed values in range. And "damaged.txt": bytes a reader must survive,
/// with what it must make of them.
std::vector<VectorFile> make_vectors();

}  // namespace umov::protocol
