{{sketch}}

module {{name}}()
  {{place}}{{below}}linear_extrude(height = {{height}}) {{sketch_name}}();
