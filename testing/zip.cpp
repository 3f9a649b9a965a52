#include "testing/zip.h"

#include <zlib.h>

#include <cstdint>

#include "core/ensure.h"

namespace partscribe::testing {
namespace {

/// Little endian, as archives have it.
template <class T>
void put(std::string& out, T value) {
  for (std::size_t k = 0; k < sizeof(T); ++k) out += static_cast<char>(value >> (8 * k));
}

std::string deflated(const std::string& bytes) {
  z_stream stream{};
  ensure(deflateInit2(&stream, 9, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY) == Z_OK, "zlib matches its header");
  std::string out(bytes.size() + 1000, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  ensure(deflate(&stream, Z_FINISH) == Z_STREAM_END, "there is room for the deflated bytes");
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

}  // namespace

std::string zip(const std::vector<std::pair<std::string, std::string>>& files, bool deflate_them) {
  std::string out, directory;
  for (const auto& file : files) {
    const std::string &name = file.first, &bytes = file.second;
    const auto data = deflate_them ? deflated(bytes) : bytes;
    const auto offset = static_cast<std::uint32_t>(out.size());
    const auto common = [&](std::string& to) {
      put<std::uint16_t>(to, 20), put<std::uint16_t>(to, 0), put<std::uint16_t>(to, deflate_them ? 8 : 0);
      put<std::uint32_t>(to, 0);  // time
      put<std::uint32_t>(to, static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(bytes.data()),
                                                              static_cast<uInt>(bytes.size()))));
      put<std::uint32_t>(to, static_cast<std::uint32_t>(data.size())),
          put<std::uint32_t>(to, static_cast<std::uint32_t>(bytes.size()));
      put<std::uint16_t>(to, static_cast<std::uint16_t>(name.size())), put<std::uint16_t>(to, 0);
    };
    out += "PK\x03\x04", common(out), out += name + data;
    directory += "PK\x01\x02", put<std::uint16_t>(directory, 20), common(directory);
    put<std::uint16_t>(directory, 0), put<std::uint16_t>(directory, 0), put<std::uint16_t>(directory, 0);
    put<std::uint32_t>(directory, 0), put<std::uint32_t>(directory, offset);
    directory += name;
  }
  const auto begin = static_cast<std::uint32_t>(out.size());
  out += directory + "PK\x05\x06";
  put<std::uint32_t>(out, 0);
  put<std::uint16_t>(out, static_cast<std::uint16_t>(files.size())),
      put<std::uint16_t>(out, static_cast<std::uint16_t>(files.size()));
  put<std::uint32_t>(out, static_cast<std::uint32_t>(directory.size())), put<std::uint32_t>(out, begin),
      put<std::uint16_t>(out, 0);
  return out;
}

}  // namespace partscribe::testing
