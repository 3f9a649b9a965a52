#include "verify/evaluate/brep_bytes.h"

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <vector>

namespace partscribe::verify {
namespace {

constexpr std::string_view magic = "partscribe brep 1\n";

class ByteWriter {
 public:
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void put(const T& value) { bytes_.append(reinterpret_cast<const char*>(&value), sizeof value); }
  void put(const std::string& text) {
    put(static_cast<std::uint64_t>(text.size()));
    bytes_ += text;
  }
  void put(const Vec3& v) {
    for (int k = 0; k < 3; ++k) put(v[k]);
  }
  template <class T>
  void put(const std::vector<T>& list) {
    put(static_cast<std::uint64_t>(list.size()));
    for (const auto& item : list) put(item);
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_{magic};
};

/// The same in the same order; `whole()` is false once something was missing, or is no value of its type.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : rest_(bytes) {
    whole_ = bytes.starts_with(magic);
    if (whole_) rest_.remove_prefix(magic.size());
  }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void get(T& value) {
    const std::string_view bytes = next(sizeof value);
    if (whole_) std::memcpy(&value, bytes.data(), sizeof value);
  }
  void get(bool& value) {
    std::uint8_t byte = 0;
    get(byte);
    whole_ = whole_ && byte <= 1;
    value = byte == 1;
  }
  void get(ErrorKind& kind) {
    int number = 0;
    get(number);
    kind = static_cast<ErrorKind>(number);
    whole_ = whole_ && kind >= ErrorKind::usage && kind <= ErrorKind::stopped;
  }
  void get(std::string& text) {
    std::uint64_t size = 0;
    get(size);
    text = next(size);
  }
  void get(Vec3& v) {
    for (int k = 0; k < 3; ++k) get(v[k]);
  }
  template <class T>
  void get(std::vector<T>& list) {
    std::uint64_t size = 0;
    get(size);
    whole_ = whole_ && size <= rest_.size();  // an item takes at least one byte
    if (!whole_) return;
    list.resize(size);
    for (auto& item : list) get(item);
  }
  bool whole() const { return whole_; }

 private:
  std::string_view rest_;
  bool whole_ = true;

  std::string_view next(std::uint64_t size) {
    whole_ = whole_ && size <= rest_.size();
    if (!whole_) return {};
    const std::string_view bytes = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return bytes;
  }
};

/// One list of what is handed over, for both directions: `pass` is put or get.
template <class Reading, class Pass>
void each_field(Reading& reading, const Pass& pass) {
  auto& e = reading.evaluation;
  pass(e.backend), pass(e.program), pass(e.version);
  pass(e.mesh.vertices), pass(e.mesh.triangles);
  pass(e.solid), pass(e.error), pass(e.failed), pass(e.complaints);
  pass(e.gap.width), pass(e.gap.kind), pass(e.gap.place);
  pass(reading.body);
}

bool is_sound(const TriangleMesh& mesh) {
  const auto is_corner = [&](std::uint32_t v) { return v < mesh.vertices.size(); };
  return std::ranges::all_of(mesh.vertices, [](const Vec3& v) { return v.allFinite(); }) &&
         std::ranges::all_of(mesh.triangles, [&](const auto& t) { return std::ranges::all_of(t, is_corner); });
}

}  // namespace

std::string to_bytes(const Result<BrepReading>& result) {
  ByteWriter writer;
  writer.put(result.ok());
  if (result.ok()) {
    each_field(*result, [&](const auto& field) { writer.put(field); });
  } else {
    writer.put(result.error().kind);
    writer.put(result.error().message);
  }
  return writer.take();
}

std::optional<Result<BrepReading>> from_bytes(std::string_view bytes) {
  ByteReader reader(bytes);
  bool ok = false;
  reader.get(ok);
  BrepReading reading;
  Error error;
  if (ok) {
    each_field(reading, [&](auto& field) { reader.get(field); });
  } else {
    reader.get(error.kind);
    reader.get(error.message);
  }
  if (!reader.whole() || !is_sound(reading.evaluation.mesh)) return std::nullopt;
  if (!ok) return Result<BrepReading>(std::move(error));
  return Result<BrepReading>(std::move(reading));
}

}  // namespace partscribe::verify
