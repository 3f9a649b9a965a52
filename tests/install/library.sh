# library.sh STAGE EXAMPLE BUILD: configures, builds and runs the example against what was installed.
stage=$1 example=$2 build=$3
rm -rf "$build"
cmake -S "$example" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$stage" >"$build.log" 2>&1 ||
  { cat "$build.log"; exit 1; }
grep -q "^partscribe_DIR:PATH=$stage/" "$build/CMakeCache.txt"
cmake --build "$build" >"$build.log" 2>&1 || { cat "$build.log"; exit 1; }
cd "$build"
scan=$stage/share/doc/partscribe/examples/pin/scan/scan.json
PATH=$stage/bin:$PATH ./scan_to_cad "$scan" 0.1 | tee said
grep -q "^shank_d = 12, " said
grep -q "^part.step .* verified" said
code=0
PATH=$stage/bin:$PATH ./scan_to_cad missing.ply 0.1 2>said || code=$?
[ "$code" -eq 3 ] && grep -q "missing.ply" said
