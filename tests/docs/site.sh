# site.sh SOURCE PROGRAM FOLDER: the site is made twice with the same bytes, no link in it is dead, and the check of that
# finds what is spoiled.
source=$1 program=$2 folder=$3
command -v mkdocs >/dev/null || { echo "skipped: mkdocs is not installed"; exit 0; }
check() { /usr/bin/python3 "$source/tests/docs/check_site.py" "$1"; }
rm -rf "$folder"
mkdir -p "$folder"
"$source/script/site" "$program" "$folder/site"
check "$folder/site"
"$source/script/site" "$program" "$folder/again"
diff -r "$folder/site" "$folder/again"

spoiled() {  # WHAT-IT-SAYS
  if check "$folder/again" >"$folder/said"; then echo "not noticed: $1"; exit 1; fi
  grep -q "$1" "$folder/said" || { echo "expected: $1; found:"; cat "$folder/said"; exit 1; }
}
cd "$folder/again/docs"
mv glossary.html gone.html
spoiled "tutorial.html links to .*glossary.html, and there is no such file"
spoiled "docs/gone.html is not in the navigation"
mv gone.html glossary.html
sed -i 's/id="exit-codes"//' cli.html
spoiled "commands/build.html links to ../cli.html#exit-codes, and the page has no such place"
echo '<img src="https://example.org/x.png">' >>install.html
spoiled "docs/install.html loads https://example.org/x.png from the network"
