// Tri surface: an octahedron
//
// A triangulation, because no procedure met the tolerance.
// Units: millimetres and degrees. Tolerance: 0.1 mm.
// Fit: rms 0.024 mm from 21,250 points, local mean within 0.051 mm, 93 % of its surface scanned.
// Source: tri_surface.ply.
// Written by partscribe 0.1.0.

module octahedron()
  polyhedron(points = octahedron_points, faces = octahedron_faces, convexity = 10);

module part() octahedron();

part();

// Corners [mm].
octahedron_points = [
  [10, 0, 0], [-10, 0, 0], [0, 12, 0], [0, -12, 0], [0, 0, 14.5], [0, 0, -9.25]
];

// Triangles, clockwise seen from outside.
octahedron_faces = [
  [0, 4, 2], [2, 4, 1], [1, 4, 3], [3, 4, 0], [2, 5, 0], [1, 5, 2], [3, 5, 1], [0, 5, 3]
];
