{{sketch}}

module {{name}}()
  {{place}}linear_extrude(height = {{height}}) {{sketch_name}}();
