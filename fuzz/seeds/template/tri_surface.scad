module {{name}}()
  {{place}}polyhedron(points = {{name}}_points, faces = {{name}}_faces, convexity = 10);
