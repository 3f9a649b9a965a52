module {{name}}()
  {{place}}translate([0, 0, {{bottom}}]) linear_extrude(height = {{height}})
    hull() {
      translate([{{back}}, 0]) disc({{radius}});
      translate([{{reach}}, 0]) disc({{radius}});
    }
