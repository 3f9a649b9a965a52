/// How far the scanned points are from the evaluated surface, as local robust means.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "verify/compare/source.h"
#include "verify/exchange/brep_distance.h"
#include "verify/verify.h"

namespace partscribe::verify {

/// A place stands for the points around it that lie on the same face.
struct Place {
  std::uint32_t point = 0;  ///< its representative in the source
  double mean = 0;          ///< mm, robust mean of the signed distances of its neighbours
  double spread = 0;        ///< mm, their scaled median absolute deviation
  double spacing = 0;       ///< mm, between the points around
  bool surface = true;      ///< false: what is there is no surface but outliers
  double error = 0;         ///< mm, standard error of `mean`
  bool decided = true;      ///< false: a deviation of twice the tolerance could hide in the error
};

/// Every source point's distance, place and fate.
struct PointField {
  std::vector<double> distance;         ///< mm, signed
  std::vector<std::uint32_t> triangle;  ///< nearest
  std::vector<std::uint32_t> place;     ///< index into places
  std::vector<std::uint8_t> outlier;    ///< 1: counted as rejected
  std::vector<std::uint8_t> crowded;    ///< 1: off the model, together with more others than outliers explain
  std::vector<Place> places;
  DataToModel summary;
  double quantile = 0;              ///< standard errors that no place of a true model is off by, in 1999 of 2000 scans
  std::vector<std::string> faults;  ///< why the data refuse the model
};

/// `normals` are the mesh's unit facet normals. Under Rule::max every kept point is judged by itself. `exact`: the
/// surfaces that the mesh approaches, where they are known; distances are then taken from them.
PointField data_to_model(const ScanSource& source, const MeshDistance& surface, const std::vector<Vec3>& normals,
                         const VerifyOptions& options, Context& context, const BrepDistance* exact = nullptr);

}  // namespace partscribe::verify
