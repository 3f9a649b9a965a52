module {{name}}() {
  n = facets({{largest_radius}});
  {{place}}{{foot}}cylinder(h = {{height}}, $fn = n,
      r1 = straddled({{bottom_radius}}, n), r2 = straddled({{top_radius}}, n));
}
