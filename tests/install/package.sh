# package.sh BUILD FOLDER VERSION: makes the Debian packages; that of the program has these files, these fields, and a
# program that runs.
build=$1 folder=$2 version=$3
for tool in dpkg-deb dpkg-shlibdeps file; do
  command -v "$tool" >/dev/null || { echo "skipped: $tool is not installed"; exit 0; }
done
rm -rf "$folder"
SOURCE_DATE_EPOCH=1700000000 cpack --config "$build/CPackConfig.cmake" -B "$folder" >/dev/null
package=$(echo "$folder"/partscribe_"$version"_*.deb)
field() { dpkg-deb --field "$package" "$1"; }
fail() { echo "$*"; exit 1; }

[ "$(field Package) $(field Version)" = "partscribe $version" ] || fail "package $(field Package) $(field Version)"
[ "$(field Architecture)" = "$(dpkg --print-architecture)" ] || fail "architecture $(field Architecture)"
for needed in openscad libocct-data-exchange-7 libocct-modeling-algorithms-7 libc6 'libstdc++6' libpng16 libgmp10; do
  case ", $(field Depends)" in *", $needed"*) ;; *) fail "$needed is not among: $(field Depends)" ;; esac
done
case ", $(field Depends)" in *-dev*) fail "needs what only a compiler needs: $(field Depends)" ;; esac
[ "$(field Recommends)" = bubblewrap ] || fail "recommends $(field Recommends)"

# Nothing but the program and what describes it, owned by root and writable by nobody else.
dpkg-deb --contents "$package" | awk '{ print $1, $2, $6 }' >"$folder/contents"
awk '$2 != "root/root" || ($1 != "drwxr-xr-x" && $1 != ($3 ~ /\/bin\// ? "-rwxr-xr-x" : "-rw-r--r--"))' \
  "$folder/contents" >"$folder/wrong"
[ ! -s "$folder/wrong" ] || fail "owner or mode: $(cat "$folder/wrong")"
awk '/^-/ { print $3 }' "$folder/contents" | sed 's,/docs/.*,/docs/,; s,/examples/.*,/examples/,' | LC_ALL=C sort -u >"$folder/files"
cat >"$folder/expected" <<'EOF'
./usr/bin/partscribe
./usr/share/bash-completion/completions/partscribe
./usr/share/doc/partscribe/README.md
./usr/share/doc/partscribe/changelog.gz
./usr/share/doc/partscribe/copyright
./usr/share/doc/partscribe/docs/
./usr/share/doc/partscribe/examples/
./usr/share/fish/vendor_completions.d/partscribe.fish
./usr/share/man/man1/partscribe.1.gz
./usr/share/zsh/vendor-completions/_partscribe
EOF
diff "$folder/expected" "$folder/files" || fail "the package holds other files than it should"

dpkg-deb --extract "$package" "$folder/root"
"$folder/root/usr/bin/partscribe" --version >"$folder/version"
[ "$(head -n 1 "$folder/version")" = "partscribe $version" ] || fail "the program is $(cat "$folder/version")"
gzip -cd "$folder/root/usr/share/man/man1/partscribe.1.gz" | grep -q "^.TH PARTSCRIBE 1 \"\" \"partscribe $version\""
gzip -cd "$folder/root/usr/share/doc/partscribe/changelog.gz" | grep -m 1 '^## [0-9]' | grep -qx "## $version" ||
  fail "the newest version of the changelog is another"
