module {{name}}()
  {{place}}bore(d = {{diameter}}, from = {{from}}, to = {{to}});
