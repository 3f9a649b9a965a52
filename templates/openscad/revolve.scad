{{sketch}}

module {{name}}() {
  n = facets({{largest_radius}});
  {{place}}rotate_extrude($fn = n) scale([straddled(1, n), 1]) {{sketch_name}}();
}
