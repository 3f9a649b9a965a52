module {{name}}() {
  n = facets({{largest_radius}});
  {{place}}cylinder(r1 = straddled({{bottom_radius}}, n), r2 = straddled({{top_radius}}, n), h = {{height}}, $fn = n);
}
