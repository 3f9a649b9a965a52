module {{name}}() {
  n = facets({{radius}});
  {{place}}cylinder(r = straddled({{radius}}, n), h = {{height}}, $fn = n);
}
