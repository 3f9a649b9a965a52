# python_package.sh FOLDER VERSION PYTHON CORPUS: the Debian package of Python has these files, these fields, and a module
# that reads STEP by the program of the other package.
folder=$1 version=$2 python=$3 corpus=$4
[ -d "$folder/root" ] || { echo "skipped: no packages were made"; exit 0; }
package=$(echo "$folder"/python3-partscribe_"$version"_*.deb)
field() { dpkg-deb --field "$package" "$1"; }
fail() { echo "$*"; exit 1; }

[ "$(field Package) $(field Version)" = "python3-partscribe $version" ] || fail "$(field Package) $(field Version)"
[ "$(field Architecture)" = "$(dpkg --print-architecture)" ] || fail "architecture $(field Architecture)"
for needed in python3-numpy "partscribe (= $version)" "python3 (>= 3" "python3 (<< 3" libocct-data-exchange-7 libc6; do
  case ", $(field Depends)" in *", $needed"*) ;; *) fail "$needed is not among: $(field Depends)" ;; esac
done
case ", $(field Depends)" in *-dev* | *openscad*) fail "needs what it should not: $(field Depends)" ;; esac

dpkg-deb --contents "$package" | awk '{ print $1, $2, $6 }' >"$folder/contents"
awk '$2 != "root/root" || ($1 != "drwxr-xr-x" && $1 != "-rw-r--r--")' "$folder/contents" >"$folder/wrong"
[ ! -s "$folder/wrong" ] || fail "owner or mode: $(cat "$folder/wrong")"
awk '/^-/ { print $3 }' "$folder/contents" | sed 's/_native\.cpython.*\.so/_native.so/' | LC_ALL=C sort >"$folder/files"
cat >"$folder/expected" <<'END'
./usr/lib/python3/dist-packages/partscribe/__init__.py
./usr/lib/python3/dist-packages/partscribe/_native.pyi
./usr/lib/python3/dist-packages/partscribe/_native.so
./usr/lib/python3/dist-packages/partscribe/errors.py
./usr/lib/python3/dist-packages/partscribe/py.typed
./usr/lib/python3/dist-packages/partscribe/results.py
./usr/share/doc/python3-partscribe/changelog.gz
./usr/share/doc/python3-partscribe/copyright
./usr/share/doc/python3-partscribe/examples/deviations.py
END
diff "$folder/expected" "$folder/files" || fail "the package holds other files than it should"
dpkg-deb --ctrl-tarfile "$package" | tar -tv >"$folder/control"
for script in postinst prerm; do
  grep -q -- "^-rwxr-xr-x root/root .* \./$script\$" "$folder/control" || fail "$script: $(cat "$folder/control")"
done

"$python" -c "import numpy" 2>/dev/null || { echo "skipped: $python has no numpy"; exit 0; }
dpkg-deb --extract "$package" "$folder/root"  # where the program was laid down by the test before
PATH=$folder/root/usr/bin:$PATH PYTHONPATH=$folder/root/usr/lib/python3/dist-packages "$python" - <<END
import partscribe, tempfile

assert partscribe.__file__.startswith("$folder"), partscribe.__file__
assert partscribe.__version__ == "$version", partscribe.__version__
with tempfile.TemporaryDirectory() as out:
    partscribe.emit("$corpus/tie_bar/model.json", out, ["step"])
    verdict = partscribe.verify(out + "/part.step", "$corpus/tie_bar/scan/scan.json", 0.1)
assert verdict.ok, verdict
END
