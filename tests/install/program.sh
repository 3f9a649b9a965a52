# program.sh STAGE SOURCE: the installed program, moved once more and with the source out of its sight, writes the files
# of an installed model and verifies them.
stage=$1 source=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp -r "$stage/bin" "$stage/share" "$work"
cd "$work"
apart="bwrap --dev-bind / / --tmpfs $source"
$apart true 2>/dev/null || apart=
partscribe() { $apart env -i PATH=/usr/bin:/bin bin/partscribe "$@"; }

example=share/doc/partscribe/examples/tie_bar
scan=$example/scan/scan.json
partscribe emit "$example/model.json" --out part --quiet
for file in part.scad part.scl prelude.scl part.igs part.step; do
  [ -s "part/$file" ] || { echo "not written: $file"; exit 1; }
done
partscribe verify part/part.scad part/part.scl part/part.step "$scan" --tolerance 0.1
sed -i 's/^thickness = [0-9.]*/thickness = 13/' part/part.scad
code=0
partscribe verify part/part.scad "$scan" --tolerance 0.1 --quiet || code=$?
[ "$code" -eq 1 ] || { echo "a bar that is a millimetre too thick ended with $code"; exit 1; }
