/// Reads ZIP archives in memory by minizip.
#include "geometry/io/read_zip.h"

#include <minizip/unzip.h>

#include <algorithm>
#include <cstring>
#include <memory>

#include "geometry/io/read_formats.h"

namespace partscribe::geometry::formats {
namespace {

/// What minizip takes for a file.
struct Memory {
  std::string_view bytes;
  std::size_t at = 0;
};

uLong read_from(voidpf, voidpf stream, void* to, uLong count) {
  auto& memory = *static_cast<Memory*>(stream);
  const std::size_t got = std::min<std::size_t>(count, memory.bytes.size() - memory.at);
  std::memcpy(to, memory.bytes.data() + memory.at, got);
  memory.at += got;
  return static_cast<uLong>(got);
}

long seek(voidpf, voidpf stream, ZPOS64_T offset, int origin) {
  auto& memory = *static_cast<Memory*>(stream);
  const std::size_t from = origin == ZLIB_FILEFUNC_SEEK_SET   ? 0
                           : origin == ZLIB_FILEFUNC_SEEK_CUR ? memory.at
                                                              : memory.bytes.size();
  if (offset > memory.bytes.size() - from) return -1;
  memory.at = from + static_cast<std::size_t>(offset);
  return 0;
}

zlib_filefunc64_def functions_over(Memory& memory) {
  zlib_filefunc64_def functions{};
  functions.opaque = &memory;
  functions.zopen64_file = [](voidpf opaque, const void*, int) { return opaque; };
  functions.zread_file = read_from;
  functions.zwrite_file = [](voidpf, voidpf, const void*, uLong) { return uLong(0); };
  functions.ztell64_file = [](voidpf, voidpf stream) { return ZPOS64_T(static_cast<Memory*>(stream)->at); };
  functions.zseek64_file = seek;
  functions.zclose_file = [](voidpf, voidpf) { return 0; };
  functions.zerror_file = [](voidpf, voidpf) { return 0; };
  return functions;
}

struct Close {
  void operator()(void* archive) const { unzClose(archive); }
};

/// What all files of an archive may take unpacked: a model shrinks some ten times, a bomb a thousand times.
std::size_t most_unpacked(std::size_t archive_size) { return std::max<std::size_t>(256u << 20, 100 * archive_size); }

/// The archive's current file, of at most `room` bytes.
Result<std::string> unpacked(unzFile archive, const unz_file_info64& info, std::size_t room, const std::string& where) {
  // Deflate never shrinks more than 1032 times; a larger claim is not believed.
  if (info.uncompressed_size / 1032 > info.compressed_size + 1 || info.uncompressed_size > room)
    return bad_input(where + "expected a credible size, found " + std::to_string(info.uncompressed_size) + " bytes");
  if (unzOpenCurrentFile(archive) != UNZ_OK)
    return bad_input(where + "expected a stored or deflated file, found one that cannot be opened");
  std::string bytes(info.uncompressed_size, '\0');
  std::size_t done = 0;
  while (done < bytes.size()) {
    const auto most = static_cast<unsigned>(std::min<std::size_t>(bytes.size() - done, 1u << 30));
    const int got = unzReadCurrentFile(archive, bytes.data() + done, most);
    if (got <= 0) break;
    done += static_cast<std::size_t>(got);
  }
  const int closed = unzCloseCurrentFile(archive);
  if (done != bytes.size())
    return bad_input(where + "expected " + std::to_string(bytes.size()) + " whole bytes, found damaged ones after " +
                     std::to_string(done));
  if (closed != UNZ_OK) return bad_input(where + "expected bytes that agree with their checksum, found others");
  return bytes;
}

}  // namespace

Result<std::vector<ZippedFile>> unzip(std::string_view bytes, const std::string& archive,
                                      const std::function<bool(const std::string&)>& wanted) {
  Memory memory{bytes};
  auto functions = functions_over(memory);
  const std::unique_ptr<void, Close> file(unzOpen2_64(archive.c_str(), &functions));
  if (!file) return bad_input(archive + ": expected a ZIP archive with a directory at its end, found none");
  std::vector<ZippedFile> files;
  std::size_t room = most_unpacked(bytes.size());
  for (int state = unzGoToFirstFile(file.get()); state != UNZ_END_OF_LIST_OF_FILE;
       state = unzGoToNextFile(file.get())) {
    unz_file_info64 info{};
    char name[4096] = {};
    if (state != UNZ_OK ||
        unzGetCurrentFileInfo64(file.get(), &info, name, sizeof name - 1, nullptr, 0, nullptr, 0) != UNZ_OK)
      return bad_input(archive + ": expected a ZIP archive with a whole directory, found a damaged one");
    if (!wanted(name)) continue;
    auto content = unpacked(file.get(), info, room, archive + ": " + shown(name) + ": ");
    if (!content) return content.error();
    room -= content->size();
    files.push_back({name, std::move(*content)});
  }
  return files;
}

}  // namespace partscribe::geometry::formats
