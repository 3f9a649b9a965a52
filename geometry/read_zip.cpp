/// Reads ZIP archives: the directory at the end, then single entries through zlib.
#include "geometry/read_zip.h"

#include <zlib.h>

#include <algorithm>

#include "geometry/read_formats.h"

namespace partscribe::formats {
namespace {

constexpr std::uint32_t directory_end = 0x06054b50, directory_entry = 0x02014b50, local_header = 0x04034b50;

}  // namespace

Result<std::vector<ZipEntry>> list_zip(std::string_view bytes, const std::string& archive) {
  const auto damaged = [&](const char* what) { return bad_input(archive + ": expected a ZIP archive with " + what + ", found none"); };
  if (bytes.size() < 22) return damaged("a directory at its end");
  // The end record is followed by a comment of up to 65535 bytes.
  std::size_t end = bytes.size() - 22;
  const std::size_t last = end > 65535 ? end - 65535 : 0;
  while (load<std::uint32_t>(bytes.data() + end) != directory_end) {
    if (end == last) return damaged("a directory at its end");
    --end;
  }
  const std::size_t count = load<std::uint16_t>(bytes.data() + end + 10);
  std::size_t at = load<std::uint32_t>(bytes.data() + end + 16);
  std::vector<ZipEntry> entries;
  for (std::size_t i = 0; i < count; ++i) {
    if (at > bytes.size() || bytes.size() - at < 46 || load<std::uint32_t>(bytes.data() + at) != directory_entry)
      return damaged("a whole directory");
    const char* p = bytes.data() + at;
    const std::size_t name_size = load<std::uint16_t>(p + 28), extra = load<std::uint16_t>(p + 30), comment = load<std::uint16_t>(p + 32);
    if (bytes.size() - at - 46 < name_size) return damaged("a whole directory");
    entries.push_back({std::string(p + 46, name_size), load<std::uint16_t>(p + 10), load<std::uint32_t>(p + 20),
                       load<std::uint32_t>(p + 24), load<std::uint32_t>(p + 42)});
    at += 46 + name_size + extra + comment;
  }
  return entries;
}

Result<std::string> unzip(std::string_view bytes, const ZipEntry& entry, const std::string& archive) {
  const auto damaged = [&](const std::string& why) { return bad_input(archive + ": " + entry.name + ": " + why); };
  if (entry.offset > bytes.size() || bytes.size() - entry.offset < 30 ||
      load<std::uint32_t>(bytes.data() + entry.offset) != local_header)
    return damaged("expected a ZIP entry at byte " + std::to_string(entry.offset) + ", found other data");
  const char* p = bytes.data() + entry.offset;
  const std::size_t begin = entry.offset + 30 + load<std::uint16_t>(p + 26) + load<std::uint16_t>(p + 28);
  if (begin > bytes.size() || bytes.size() - begin < entry.packed)
    return damaged("expected " + std::to_string(entry.packed) + " packed bytes, found the end of the file");
  const auto packed = bytes.substr(begin, entry.packed);
  if (entry.method == 0) return std::string(packed);
  if (entry.method != 8) return damaged("expected a stored or deflated entry, found method " + std::to_string(entry.method));
  // Deflate never shrinks more than 1032 times; a larger claim is not believed.
  if (entry.size / 1032 > entry.packed + 1) return damaged("expected a credible size, found " + std::to_string(entry.size) + " bytes");
  std::string out(entry.size, '\0');
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) return damaged("cannot be unpacked");
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int state = inflate(&stream, Z_FINISH);
  const std::size_t written = stream.total_out;
  inflateEnd(&stream);
  if (state != Z_STREAM_END || written != entry.size) return damaged("expected whole deflated data, found damaged ones");
  return out;
}

}  // namespace partscribe::formats
