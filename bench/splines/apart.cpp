#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <ctime>

#include "peers.h"

namespace bench {
namespace {

double peak_megabytes() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) / 1024;
}

bool write_all(int to, const std::vector<double>& numbers) {
  const char* from = reinterpret_cast<const char*>(numbers.data());
  std::size_t left = numbers.size() * sizeof(double);
  while (left > 0) {
    const ssize_t done = write(to, from, left);
    if (done <= 0) return false;
    from += done, left -= std::size_t(done);
  }
  return true;
}

}  // namespace

std::vector<double> numbers_of(const NurbsSurface& surface) {
  std::vector<double> numbers;
  for (const auto* k : {&surface.u, &surface.v}) {
    numbers.push_back(k->degree), numbers.push_back(double(k->knots.size()));
    numbers.insert(numbers.end(), k->knots.begin(), k->knots.end());
  }
  for (const Vec3& p : surface.points) numbers.insert(numbers.end(), {p.x(), p.y(), p.z()});
  return numbers;
}

std::optional<NurbsSurface> surface_of(const std::vector<double>& numbers, std::size_t& next) {
  NurbsSurface surface;
  for (auto* k : {&surface.u, &surface.v}) {
    if (next + 2 > numbers.size()) return std::nullopt;
    k->degree = int(numbers[next]);
    const auto count = std::size_t(numbers[next + 1]);
    next += 2;
    if (next + count > numbers.size()) return std::nullopt;
    k->knots.assign(numbers.begin() + std::ptrdiff_t(next), numbers.begin() + std::ptrdiff_t(next + count));
    next += count;
  }
  const auto count = std::size_t(surface.u.count()) * std::size_t(surface.v.count());
  if (next + 3 * count > numbers.size()) return std::nullopt;
  for (std::size_t i = 0; i < count; ++i, next += 3)
    surface.points.emplace_back(numbers[next], numbers[next + 1], numbers[next + 2]);
  return surface;
}

NurbsSurface graph_of(const std::vector<double>& u, const std::vector<double>& v, int degree,
                      const std::vector<double>& coefficients) {
  NurbsSurface surface{{degree, u}, {degree, v}, {}, {}};
  // The parameter itself has the means of the knots as coefficients.
  const auto mean = [&](const std::vector<double>& t, int i) {
    double sum = 0;
    for (int k = 1; k <= degree; ++k) sum += t[std::size_t(i + k)];
    return sum / degree;
  };
  std::size_t next = 0;
  for (int i = 0; i < surface.u.count(); ++i)
    for (int j = 0; j < surface.v.count(); ++j)
      surface.points.emplace_back(mean(u, i), mean(v, j), coefficients[next++]);
  return surface;
}

std::optional<Answer> asked_apart(const std::function<std::optional<NurbsSurface>()>& fit, double seconds) {
  int ends[2];
  if (pipe(ends) != 0) return std::nullopt;
  const pid_t child = fork();
  if (child < 0) return std::nullopt;
  if (child == 0) {
    close(ends[0]);
    const auto most = static_cast<rlim_t>(std::ceil(seconds + double(std::clock()) / CLOCKS_PER_SEC));
    const rlimit limit{most, most + 1};
    setrlimit(RLIMIT_CPU, &limit);
    const double memory = peak_megabytes(), before = double(std::clock());
    const auto surface = fit();
    const double taken = (double(std::clock()) - before) / CLOCKS_PER_SEC;
    bool done = false;
    if (surface) {
      std::vector<double> numbers = {taken, peak_megabytes() - memory};
      const auto more = numbers_of(*surface);
      numbers.insert(numbers.end(), more.begin(), more.end());
      done = write_all(ends[1], numbers);
    }
    _exit(done ? 0 : 1);
  }
  close(ends[1]);
  std::vector<double> numbers;
  std::string bytes;
  char buffer[65536];
  for (ssize_t got; (got = read(ends[0], buffer, sizeof buffer)) > 0;) bytes.append(buffer, std::size_t(got));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return std::nullopt;
  numbers.resize(bytes.size() / sizeof(double));
  std::copy(bytes.begin(), bytes.begin() + std::ptrdiff_t(numbers.size() * sizeof(double)),
            reinterpret_cast<char*>(numbers.data()));
  if (numbers.size() < 2) return std::nullopt;
  std::size_t next = 2;
  auto surface = surface_of(numbers, next);
  if (!surface) return std::nullopt;
  return Answer{std::move(*surface), numbers[0], numbers[1]};
}

}  // namespace bench
