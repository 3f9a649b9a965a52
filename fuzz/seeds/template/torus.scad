module {{name}}() {
  n = facets({{outer_radius}});
  {{place}}rotate_extrude($fn = n) scale([straddled(1, n), 1]) translate([{{major_radius}}, 0]) disc({{minor_radius}});
}
