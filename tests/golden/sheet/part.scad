// Sheet: a bent sheet
//
// A triangulation, because no procedure met the tolerance.
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: sheet.ply.
// Written by partscribe 0.1.0.

use <partscribe.scad>

/* [Bent sheet] */
// of the solid made from the sheet [mm]
sheet_thickness = 2;

assert(sheet_thickness >= 0, "sheet_thickness must not be negative");

// An open sheet; what OpenSCAD builds is a solid that reaches this thickness behind it.
module bent_sheet()
  thick_sheet(bent_sheet_points, bent_sheet_normals, bent_sheet_faces, bent_sheet_rim, thickness = sheet_thickness);

module part() bent_sheet();

part();

// Corners [mm].
bent_sheet_points = [
  [0, 0, 4], [10, 0, 1], [20, 0, 0], [30, 0, 1], [40, 0, 4], [0, 12, 4.5], [10, 12, 1.5],
  [20, 12, 0.5], [30, 12, 1.5], [40, 12, 4.5], [0, 24, 5], [10, 24, 2], [20, 24, 1], [30, 24, 2],
  [40, 24, 5]
];

// Outward directions at the corners, scaled so that the sheet moves by its thickness.
bent_sheet_normals = [
  [0.287119, -0.039878, 0.957064], [0.194577, -0.041032, 0.984779], [0, -0.041838, 1.004108],
  [-0.194577, -0.041032, 0.984779], [-0.287119, -0.039878, 0.957064],
  [0.287119, -0.039878, 0.957064], [0.195054, -0.041027, 0.984636], [0, -0.041838, 1.004108],
  [-0.195054, -0.041027, 0.984636], [-0.287119, -0.039878, 0.957064],
  [0.287119, -0.039878, 0.957064], [0.195548, -0.041024, 0.984587], [0, -0.041838, 1.004108],
  [-0.195548, -0.041024, 0.984587], [-0.287119, -0.039878, 0.957064]
];

// Edges of the boundary.
bent_sheet_rim = [
  [1, 0], [0, 5], [2, 1], [3, 2], [4, 3], [9, 4], [10, 11], [5, 10], [11, 12], [12, 13], [14, 9],
  [13, 14]
];

// Triangles, clockwise seen from outside.
bent_sheet_faces = [
  [0, 6, 1], [0, 5, 6], [1, 7, 2], [1, 6, 7], [2, 8, 3], [2, 7, 8], [3, 9, 4], [3, 8, 9],
  [5, 11, 6], [5, 10, 11], [6, 12, 7], [6, 11, 12], [7, 13, 8], [7, 12, 13], [8, 14, 9], [8, 13, 14]
];
