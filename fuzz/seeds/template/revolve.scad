{{sketch}}

module {{name}}() {
  n = facets({{largest_radius}});
  {{place}}rotate_extrude({{angle}}$fn = n) scale([straddled(1, n), 1]) {{sketch_name}}();
}
