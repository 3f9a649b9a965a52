# stage.sh BUILD STAGE: installs, and looks for what must be there.
build=$1 stage=$2
rm -rf "$stage"
cmake --install "$build" --prefix "$stage" >/dev/null
cd "$stage"
for file in bin/partscribe share/man/man1/partscribe.1.gz share/bash-completion/completions/partscribe \
  share/zsh/vendor-completions/_partscribe share/fish/vendor_completions.d/partscribe.fish \
  share/doc/partscribe/copyright share/doc/partscribe/examples/pin/scan/scan.json \
  lib*/libpartscribe_fit.a lib*/cmake/partscribe/partscribe-config.cmake include/partscribe/fit/build.h; do
  [ -s "$file" ] || { echo "not installed: $file"; exit 1; }
done
