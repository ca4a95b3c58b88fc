#include <fmt/format.h>
#include <fmt/ranges.h>

#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>

#include <exception>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/image_file.hpp"

namespace umov::formats {
namespace {

Imf::Slice slice_of(std::vector<float>& values, std::size_t width) {
  return Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), sizeof(float),
                    sizeof(float) * width);
}

/// What `read` makes of the file; the library's exceptions become the project's.
template <class Read>
auto opened(const std::filesystem::path& path, Read&& read) {
  try {
    Imf::InputFile in(path.string().c_str());
    return read(in);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw Error(Place{path.string()}, std::string("OpenEXR cannot read it: ") + error.what(),
                "give an OpenEXR file");
  }
}

ExrHeader header_of(const Imf::InputFile& in, const std::filesystem::path& path) {
  const auto box = in.header().dataWindow();
  if (box.min.x != 0 || box.min.y != 0) {
    throw Error(Place{path.string(), 0, "dataWindow"}, "the pixels do not begin at (0, 0)",
                "give the whole image, not a crop");
  }
  ExrHeader header;
  header.width = static_cast<std::size_t>(box.max.x - box.min.x + 1);
  header.height = static_cast<std::size_t>(box.max.y - box.min.y + 1);
  for (auto c = in.header().channels().begin(); c != in.header().channels().end(); ++c)
    header.channels.emplace_back(c.name());
  for (auto a = in.header().begin(); a != in.header().end(); ++a) {
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&a.attribute()))
      header.attributes.emplace_back(a.name(), text->value());
  }
  return header;
}

}  // namespace

void write_exr(const std::filesystem::path& path, std::size_t width, std::size_t height,
               std::span<const ImagePlane> planes,
               const std::vector<std::pair<std::string, std::string>>& attributes) {
  ReplacedFile file(path);
  try {
    Imf::Header header(static_cast<int>(width), static_cast<int>(height));
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::FrameBuffer buffer;
    std::vector<std::vector<float>> stored;
    stored.reserve(planes.size());
    for (const ImagePlane& plane : planes) {
      header.channels().insert(plane.name, Imf::Channel(Imf::FLOAT));
      std::vector<float>& values = stored.emplace_back();
      for (const double value : plane.values) values.push_back(static_cast<float>(value));
      buffer.insert(plane.name, slice_of(values, width));
    }
    for (const auto& [name, text] : attributes) {
      header.insert(name, Imf::StringAttribute(text));
    }
    Imf::OutputFile out(file.temporary().string().c_str(), header);
    out.setFrameBuffer(buffer);
    out.writePixels(static_cast<int>(height));
  } catch (const std::exception& error) {
    throw Error(Place{path.string()}, std::string("OpenEXR cannot write it: ") + error.what(),
                "check the folder and the space left");
  }
  file.commit();
}

ExrHeader read_exr_header(const std::filesystem::path& path) {
  return opened(path, [&](Imf::InputFile& in) { return header_of(in, path); });
}

bool looks_like_exr(std::string_view bytes) {
  return bytes.starts_with("\x76\x2f\x31\x01");
}

std::vector<double> read_exr(const std::filesystem::path& path, const std::string& channel,
                             std::size_t& width, std::size_t& height) {
  return opened(path, [&](Imf::InputFile& in) {
    const ExrHeader header = header_of(in, path);
    width = header.width;
    height = header.height;
    if (in.header().channels().findChannel(channel) == nullptr) {
      throw Error(Place{path.string(), 0, channel}, "there is no such channel",
                  fmt::format("it has: {}", fmt::join(header.channels, ", ")));
    }
    require_readable_size(width * height * sizeof(float), path.string());
    std::vector<float> values(width * height);
    Imf::FrameBuffer buffer;
    buffer.insert(channel, slice_of(values, width));
    in.setFrameBuffer(buffer);
    in.readPixels(in.header().dataWindow().min.y, in.header().dataWindow().max.y);
    return std::vector<double>(values.begin(), values.end());
  });
}

}  // namespace umov::formats
