/// Faces grown from seeds: a surface is fitted to a few samples, takes its neighbours in, and is fitted again.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/segment/face_samples.h"
#include "geometry/surfaces/primitive_fit.h"

namespace partscribe::geometry {

/// What a face may be, the plainest first.
inline constexpr std::array face_kinds = {PrimitiveKind::plane, PrimitiveKind::cylinder, PrimitiveKind::sphere,
                                          PrimitiveKind::cone, PrimitiveKind::torus};

/// One surface and the samples it explains.
struct GrownFace {
  Primitive surface;
  double sense = 1;                    ///< +1: normals of samples point to where distance() is positive, -1: against
  std::vector<std::uint32_t> members;  ///< samples, ascending
  double gain = 0;                     ///< how much shorter the scan is described with it (nats)
};

inline constexpr double widest_distance = 2.8;  ///< sigmas that a sample may lie off its surface
inline constexpr double widest_turn = 0.35;     ///< rad between the normals of sample and surface

/// Residual of a sample in sigmas, and the angle (rad) of its normal to the surface's.
double residual_of(const FaceSamples& samples, std::uint32_t sample, const Primitive& surface);
double turn_of(const FaceSamples& samples, std::uint32_t sample, const Primitive& surface, double sense);

/// What a surface costs (nats): 25 and 10 for each of its numbers, and as much for each as a systematic error of a
/// tenth of the noise could feign.
double cost_of(PrimitiveKind kind, std::size_t members);

/// What the members save, less what the surface costs: each sample that is explained saves up to 2 nats.
double gain_of(const FaceSamples& samples, const Primitive& surface, const std::vector<std::uint32_t>& members);

/// Each point with its own sigma (mm); those that lie far off count less (Welsch, 2.5 sigmas).
std::optional<PrimitiveFit> robust_fit(PrimitiveKind kind, const std::vector<Vec3>& points,
                                       const std::vector<Vec3>& normals, const std::vector<double>& sigmas,
                                       const std::optional<Primitive>& start);

/// The robust fit of one kind to these samples; nothing if they do not fix it.
std::optional<Primitive> fit_samples(const FaceSamples& samples, PrimitiveKind kind,
                                     const std::vector<std::uint32_t>& members, const std::optional<Primitive>& start);

/// The best face about `seed` among samples whose `taken` is 0; nothing if none pays.
std::optional<GrownFace> grow_face(const FaceSamples& samples, std::uint32_t seed,
                                   const std::vector<std::uint8_t>& taken, int threads);

/// +1 or -1: which way the normals of these samples point.
double sense_of(const FaceSamples& samples, const Primitive& surface, const std::vector<std::uint32_t>& members);

}  // namespace partscribe::geometry
